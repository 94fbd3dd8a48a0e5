// Colours that canvas and scene share with the style sheet.

export interface Theme {
  dark: boolean;
  background: string;
  ground: string;
  grid: string;
  text: string;
  faint: string;
  rule: string;
  accent: string;
  danger: string;
  series: string[];
  /** by contact mode: open, sticking, sliding, between directions */
  modes: string[];
  force: string;
  neutral: string;
  /** x, y, z */
  axes: string[];
  bodies: string[];
}

/** The values that the style sheet's variables have now. */
export function currentTheme(): Theme {
  const style = getComputedStyle(document.documentElement);
  const color = (name: string) => style.getPropertyValue(`--${name}`).trim();
  const list = (name: string, count: number) =>
    Array.from({ length: count }, (_, i) => color(`${name}-${i}`));
  return {
    dark: document.documentElement.dataset.theme === "dark",
    background: color("sky"),
    ground: color("ground"),
    grid: color("grid"),
    text: color("text"),
    faint: color("faint"),
    rule: color("rule"),
    accent: color("accent"),
    danger: color("danger"),
    series: list("series", 5),
    modes: list("mode", 4),
    force: color("force"),
    neutral: color("neutral"),
    axes: list("axis", 3),
    bodies: list("body", 8),
  };
}

/** Starts with the system's preference; `toggle` switches. */
export function setTheme(dark: boolean): void {
  document.documentElement.dataset.theme = dark ? "dark" : "light";
}
