"""Draws what curves.py found, and writes its table on docs/performance.md (between its markers). Needs nothing but results/curves.json.

    python3 benchmarks/sim/curves_plot.py
"""

import json
import math
import pathlib

from report import COLORS, OWN, short

HERE = pathlib.Path(__file__).resolve().parent
PAGE = HERE.parents[1] / "docs" / "performance.md"
BEGIN, END = "<!-- curves: written by curves_plot.py -->", "<!-- end of curves -->"
BUDGETS = (10, 20, 35, 50, 100, 1000)  # ms a step
WIDTH, HEIGHT, LEFT, BOTTOM, TOP, COLUMNS = 290, 250, 44, 36, 24, 4
STYLE = """<style>
svg { font: 10px sans-serif } text { fill: #24292f } .ground { fill: #ffffff } .grid { stroke: #d8dee4 } .title { font-weight: bold }
@media (prefers-color-scheme: dark) { text { fill: #d1d7e0 } .ground { fill: #161b22 } .grid { stroke: #30363d } }
</style>"""


def line_of(engine, variant):
    """What belongs to one line of the plot: an engine, of ours budgets or tolerances."""
    return f"{engine}, a budget" if variant.endswith("sweeps") else f"{engine}, a tolerance" if engine == OWN else engine


def is_default(point):
    """Whether an engine does so many iterations where nothing is said."""
    return point["variant"] in ("cg", "default", "quick", "it4-coulomb")


def measured(moment):
    return [point for point in moment["points"] if point.get("ms")]


class Axis:
    """A logarithmic axis between two powers of ten on some pixels."""

    def __init__(self, values, first, last, least=-12):
        logs = [math.log10(value) for value in values if value and value > 10.0**least]
        self.low, self.high = math.floor(min(logs)), max(math.ceil(max(logs)), math.floor(min(logs)) + 1)
        self.first, self.last = first, last

    def __call__(self, value):
        power = max(math.log10(value) if value else -math.inf, self.low)
        return self.first + (power - self.low) / (self.high - self.low) * (self.last - self.first)

    def powers(self):
        return range(self.low, self.high + 1)


def panel(name, moment, key, label, across, up):
    points = [point for point in measured(moment) if point.get(key) is not None]
    out = [f'<text class="title" x="{LEFT}" y="14">{name.replace("_", " ")}</text>']
    for power in across.powers():
        x = across(10.0**power)
        out.append(f'<line class="grid" x1="{x:.1f}" x2="{x:.1f}" y1="{up.first}" y2="{up.last}"/>')
        out.append(f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 12}" text-anchor="middle">{10.0**power:g}</text>')
    for power in up.powers():
        y = up(10.0**power)
        out.append(f'<line class="grid" x1="{across.first}" x2="{across.last}" y1="{y:.1f}" y2="{y:.1f}"/>')
        out.append(f'<text x="{LEFT - 4}" y="{y + 3:.1f}" text-anchor="end">1e{power}</text>')
    out.append(f'<text x="{(LEFT + WIDTH) / 2}" y="{HEIGHT - 8}" text-anchor="middle">ms a step</text>')
    out.append(f'<text transform="translate(10,{HEIGHT / 2}) rotate(-90)" text-anchor="middle">{label}</text>')
    for row in lines(points).values():
        color, width = COLORS[row[0]["engine"]], 2 if row[0]["engine"] == OWN else 1
        counted = [point for point in row if point["variant"] != "cg"]  # it stops early, between the counts
        path = " ".join(f"{across(point['ms']):.1f},{up(point[key]):.1f}" for point in counted)
        out.append(f'<polyline points="{path}" fill="none" stroke="{color}" stroke-width="{width}"/>')
        out += [mark(point, across(point["ms"]), up(point[key]), color, key) for point in row]
    return "".join(out)


def lines(points):
    """The points of every line, in the order of their iterations."""
    found = {}
    for point in points:
        found.setdefault(line_of(point["engine"], point["variant"]), []).append(point)
    return found


def mark(point, x, y, color, key):
    title = f"<title>{point['engine']} {point['variant']}: {point['ms']:.3g} ms, {point[key]:.2g}</title>"
    if point["engine"] == OWN and not point["variant"].endswith("sweeps"):
        return f'<rect x="{x - 3:.1f}" y="{y - 3:.1f}" width="6" height="6" fill="{color}">{title}</rect>'
    ring = f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="none" stroke="{color}"/>' if is_default(point) else ""
    return f'{ring}<circle cx="{x:.1f}" cy="{y:.1f}" r="{3 if point["engine"] == OWN else 2.2}" fill="{color}">{title}</circle>'


def draw(moments, key="worst", label="worst residual"):
    """One panel for each moment, all with the same axes, as SVG."""
    points = [point for moment in moments.values() for point in measured(moment)]
    across = Axis([point["ms"] for point in points], LEFT, WIDTH - 12)
    up = Axis([point[key] for point in points if point.get(key)], HEIGHT - BOTTOM, TOP)
    rows = math.ceil(len(moments) / COLUMNS)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{COLUMNS * WIDTH}" height="{rows * HEIGHT + 26}">{STYLE}',
           '<rect class="ground" width="100%" height="100%"/>']  # fmt: skip
    for k, (name, moment) in enumerate(moments.items()):
        place = f"translate({k % COLUMNS * WIDTH},{k // COLUMNS * HEIGHT + 26})"
        out.append(f'<g transform="{place}">{panel(name, moment, key, label, across, up)}</g>')
    for k, (name, row) in enumerate(lines(points).items()):
        shape, color = f'transform="translate({20 + 150 * k},13)"', COLORS[row[0]["engine"]]
        mark_of = f'<rect {shape} x="-3" y="-3" width="6" height="6" fill="{color}"/>' if "tolerance" in name else f'<circle {shape} r="3" fill="{color}"/>'
        out.append(f'{mark_of}<text x="{29 + 150 * k}" y="17">{name}</text>')
    out.append(f'<text x="{COLUMNS * WIDTH - 12}" y="17" text-anchor="end">rings: defaults</text>')
    return "\n".join([*out, "</svg>\n"])


def best(points, budget, key):
    """The point with the lowest residual among those that take at most so many ms."""
    return min((point for point in points if point["ms"] <= budget and point.get(key) is not None), key=lambda point: point[key], default=None)


def table(moments, key="worst"):
    """What the best of ours and the best of all others leave in a time."""
    lines = ["| at most | " + " | ".join(f"{budget} ms" for budget in BUDGETS) + " |", "|" + "---|" * (len(BUDGETS) + 1)]
    for name, moment in moments.items():
        cells = []
        for budget in BUDGETS:
            own = best([point for point in measured(moment) if point["engine"] == OWN], budget, key)
            other = best([point for point in measured(moment) if point["engine"] != OWN], budget, key)
            text = short(own[key]) if own else "–"
            wins = own and (not other or own[key] < other[key])
            text = f"**{text}**" if wins else text
            cells.append(f"{text} / " + (f"{short(other[key])} {other['engine']}" if other else "–"))
        lines.append(f"| {name.replace('_', ' ')} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def write(results, folder):
    moments, machine = results["moments"], results["machine"]
    (folder / "results" / "curves.svg").write_text(draw(moments))
    (folder / "results" / "curves_depth.svg").write_text(draw(moments, "penetration_mm", "deepest overlap, mm"))
    if BEGIN not in PAGE.read_text():
        return
    before, rest = PAGE.read_text().split(BEGIN)
    versions = sorted({f"{point['engine']} {point['version']}" for moment in moments.values() for point in moment["points"]})
    head = f"Measured {machine['date']} on {machine['processor']} ({machine['cores']} cores shared with others, load {machine['load_at_the_end']} at the end): {', '.join(versions)}.\n"
    text = "\n".join([BEGIN, head, "The worst residual, ours / the best other's:\n", table(moments), "\nThe root mean square:\n", table(moments, "rms"), ""])
    PAGE.write_text(before + text + END + rest.split(END)[1])


if __name__ == "__main__":
    write(json.loads((HERE / "results" / "curves.json").read_text()), HERE)
