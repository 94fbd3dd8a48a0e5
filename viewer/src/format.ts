// Numbers for people.

const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/** A number with a few significant digits: 0.00123, 12.3, 1.2×10⁻⁹. */
export function number(value: number | null, digits = 3): string {
  if (value === null || Number.isNaN(value)) return "not a number";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (value === 0) return "0";
  const magnitude = Math.abs(value);
  if (magnitude >= 1e-3 && magnitude < 1e5) {
    return Number(value.toPrecision(digits)).toString().replace("-", "−");
  }
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  if (Number(mantissa) === 1) return power(Number(exponent));
  return `${Number(mantissa)}×${power(Number(exponent))}`.replace("-", "−");
}

/** 10 to an integer: 10⁻⁹. */
export function power(exponent: number): string {
  const raised = [...Math.abs(exponent).toString()].map((c) => SUPERSCRIPTS[Number(c)]).join("");
  return `10${exponent < 0 ? "⁻" : ""}${raised}`;
}

/** 12,345 */
export function integer(value: number): string {
  return Math.round(value).toLocaleString("en");
}

/** Seconds with as many decimals as the step asks for. */
export function seconds(value: number, timestep: number): string {
  const decimals = Math.min(6, Math.max(2, Math.ceil(-Math.log10(timestep))));
  return value.toFixed(decimals);
}
