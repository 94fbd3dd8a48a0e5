"""Writes what the results say: the tables of README.md (between its markers) and the plot results/speed.svg.

    python3 benchmarks/sim/report.py

Needs nothing but the result files.
"""

import json
import math
import pathlib

HERE = pathlib.Path(__file__).resolve().parent
BEGIN, END = "<!-- tables: written by report.py -->", "<!-- end of tables -->"
OWN = "signorini"
COLORS = {"signorini": "#d62728", "mujoco": "#1f77b4", "drake": "#9467bd", "bullet": "#2ca02c", "dart": "#8c564b", "ode": "#ff7f0e",
          "rapier": "#7f7f7f"}  # fmt: skip

# Scenes in the order of the page, the columns that only they have.
SPECIAL = {
    "S1_slide": [("slide error %", "slide_error_percent"), ("hop mm", "hop_mm")],
    "S1_stick": [("creep mm/s", "creep_mm_s")],
    "S2_stack10": [("stands", "stands")], "S2_stack20": [("stands", "stands")], "S3_wall10": [("stands", "stands")],
    "S4_pile100": [("lost", "lost")], "S4_pile300": [("lost", "lost")], "S4_pile1000": [("lost", "lost")],
    "S4_pile3000": [("lost", "lost")], "S4s_pile100": [], "S4s_pile300": [], "S4s_pile1000": [], "S4s_pile3000": [],
    "S4r_pile100": [("stands", "stands")], "S4r_pile300": [("stands", "stands")],
    "S4r_pile1000": [("stands", "stands")], "S4r_pile3000": [("stands", "stands")],
    "S5_spheres1000": [("lost", "lost")],
    "S6_quadruped": [("height m", "height_end_m"), ("drift m", "drift_m")], "S7_humanoid": [("height m", "height_end_m")],
    "S8_cards": [("stands", "stands")], "S9_massratio": [("stands", "stands")],
    "S10_chain": [("joint gap mm", "gap_mm")], "S10_chain_2ms": [("joint gap mm", "gap_mm")],
    "S12_gripper": [("slip mm/s", "slip_mm_s"), ("held", "held")],
    **{f"S13_bricks{n}": [("stands", "stands")] for n in (96, 306, 1000, 3038, 10000)},
}  # fmt: skip


def short(value):
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "**no**"
    if isinstance(value, (int, str)):
        return str(value)
    size = abs(value)
    if size == 0:
        return "0"
    return f"{value:.1e}" if size < 1e-3 or size >= 1e6 else f"{value:.3g}"


def ended(row, duration):
    """How far a run came, where that is not the end."""
    if row["done"] == row["planned"]:
        return "–"
    why = "gave up" if row.get("error") else "time"
    return f"{why} at {row['t_end']:.3g} s"


def energy(row):
    """Deviation of the total energy in % of the largest kinetic energy where nothing may change it, else its gain in J."""
    if row.get("kinetic_max_J") and row.get("energy_deviation_J") is not None and row["scene"].startswith("S10"):
        return short(100 * row["energy_deviation_J"] / row["kinetic_max_J"]) + " %"
    return short(row.get("energy_gain_J"))


def laws(row):
    found = row.get("laws")
    if not found:
        return "–"
    text = " / ".join(short(found[key]) for key in ("signorini", "dissipation", "cone"))
    # Forces that do not explain the step say nothing about its laws.
    return text if found.get("momentum", 0) < 0.01 else f"({text})"


def budget_table(judged, raw, scenes, budgets):
    """Every engine over the steps that all of them have made: mean CPU time of these, and what the judge found; ours with so many sweeps."""
    lines = ["| scene | engine | steps | ms a step | over the quickest other | penetration mm | dissipation mm/s | cone | momentum |", "|" + "---|" * 9]
    ours = [f"{sweeps} sweeps" for sweeps in budgets]
    for name in scenes:
        runs = {}
        for path in sorted(raw.glob(f"{name}__*__0.json")):
            run = json.loads(path.read_text())
            if run["step_ns"] and (run["engine"] != OWN or run["variant"] in ours):
                runs[run["engine"], run["variant"]] = run["step_ns"]
        if not runs:
            continue
        steps = min(map(len, runs.values()))
        mean = {key: sum(times[:steps]) / steps / 1e6 for key, times in runs.items()}
        quickest = min((time for (engine, _), time in mean.items() if engine != OWN), default=math.nan)
        rows = {(row["engine"], row["variant"]): row for row in json.loads((judged / f"{name}.json").read_text())["rows"]}
        for (engine, variant), time in sorted(mean.items(), key=lambda item: (item[0][0] != OWN, item[0])):
            row = rows[engine, variant]
            found = row.get("laws") or {}
            cells = [short(row.get("penetration_max_mm"))] + [short(found.get(key)) for key in ("dissipation", "cone", "momentum")]
            lines.append(" | ".join([f"| {name}", f"{engine} {variant}", str(steps), short(time), short(time / quickest), *cells]) + " |")
    return "\n".join(lines)


def table(result):
    own = next((row for row in result["rows"] if row["engine"] == OWN and row.get("us_step")), None)
    special = SPECIAL[result["scene"]]
    robot = "drift_m" in (own or {})
    columns = ["engine", "µs a step", "ratio", "spread", "contacts"]
    if not robot:
        columns += ["penetration mm", "drop / drift mm", "energy gain J", "laws"]
    columns += [head for head, _ in special] + ["cut off"]
    lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    order = sorted(result["rows"], key=lambda row: (row["engine"] != OWN, row["engine"], row["variant"]))
    for row in order:
        row["scene"] = result["scene"]
        name = f"**{OWN}**" if row["engine"] == OWN else f"{row['engine']} {row['variant']}"
        if "us_step" not in row:
            lines.append(f"| {name} | failed: {row['failed'][:60]} |" + " |" * (len(columns) - 2))
            continue
        ratio = row["us_step"] / own["us_step"] if own else None
        times = row["us_repetitions"]
        spread = f"{min(times):.3g}–{max(times):.3g}" if len(times) > 1 else "one run"
        cells = [name, short(row["us_step"]), short(ratio), spread, short(row["contacts"])]
        if row.get("failed"):
            cells += [row["failed"]] + ["–"] * (len(columns) - len(cells) - 2)
        else:
            if not robot:
                moved = f"{short(row['drop_mm'])} / {short(row['drift_mm'])}"
                cells += [short(row["penetration_max_mm"]), moved, energy(row), laws(row)]
            cells += [short(row.get(key)) for _, key in special]
        lines.append("| " + " | ".join([*cells, ended(row, result["duration"])]) + " |")
    if own:
        lines += ["", certificate(own)]
    return f"### {result['scene']}: {result['what']}\n\n" + "\n".join(lines) + "\n"


def certificate(own):
    text = f"Certificate of our {own['done']} steps: worst residual {short(own['certificate_worst'])}, median "
    text += f"{short(own['certificate_median'])}; steps that missed {own.get('tolerance', 1e-9):.0e}: {own['missed']}"
    text += f"; steps that took negative gaps as zero: {own['clipped']}" if own["clipped"] else ""
    text += f"; slowest step {own['us_worst'] / 1e3:.3g} ms"
    return text + (f". It ended early: {own['error']}" if own.get("error") else ".")


def fastest_that_holds(result):
    """The quickest engine whose scene came out as it must, and ours."""
    good = [row for row in result["rows"] if row.get("us_step") and row.get("stands", row.get("held", True)) and not row.get("failed")]
    others = [row for row in good if row["engine"] != OWN]
    own = next((row for row in result["rows"] if row["engine"] == OWN), None)
    return own, min(others, key=lambda row: row["us_step"], default=None)


def overview(results):
    """One line per scene."""
    columns = ["scene", "ours µs", "missed / steps", "penetration mm", "quickest other that holds", "its µs", "our time over its", "its penetration mm"]
    lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    for result in results:
        own, other = fastest_that_holds(result)
        if not own or "us_step" not in own or own.get("error"):
            continue
        cells = [result["scene"], short(own["us_step"]), f"{own['missed']} / {own['done']}", short(own.get("penetration_max_mm"))]
        if other:
            ratio = short(own["us_step"] / other["us_step"])
            cells += [f"{other['engine']} {other['variant']}", short(other["us_step"]), ratio, short(other.get("penetration_max_mm"))]
        else:
            cells += ["–"] * 4
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def plot(results):
    """Time of a step against the deepest penetration, one panel per scene, logarithmic, as SVG."""
    panels = [r for r in results if any(row.get("penetration_max_mm") is not None for row in r["rows"]) and not r["scene"].startswith("S10")]
    width, height, margin, columns = 300, 220, 44, 3
    rows = math.ceil(len(panels) / columns)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{columns * width}" height="{rows * height + 30}" font-family="sans-serif" font-size="10">',
           '<rect width="100%" height="100%" fill="white"/>']  # fmt: skip
    for k, result in enumerate(panels):
        out.append(f'<g transform="translate({k % columns * width},{k // columns * height + 30})">{panel(result, width, height, margin)}</g>')
    for k, (engine, color) in enumerate(COLORS.items()):
        out.append(f'<circle cx="{20 + 95 * k}" cy="15" r="4" fill="{color}"/><text x="{28 + 95 * k}" y="19">{engine}</text>')
    return "\n".join([*out, "</svg>\n"])


def panel(result, width, height, margin):
    points = [row for row in result["rows"] if row.get("us_step") and row.get("penetration_max_mm") is not None]
    floor = 1e-7  # depths below a tenth of a nanometre are drawn there
    x = [math.log10(row["us_step"]) for row in points]
    left, right = math.floor(min(x)), math.ceil(max(x) + 1e-9)
    bottom, top = -7, 4
    across = lambda v: margin + (v - left) / (right - left) * (width - margin - 14)  # noqa: E731
    up = lambda v: height - 34 - (v - bottom) / (top - bottom) * (height - 60)  # noqa: E731
    out = [f'<text x="{margin}" y="14" font-weight="bold">{result["scene"]}</text>']
    for power in range(left, right + 1):
        out.append(f'<line x1="{across(power):.1f}" x2="{across(power):.1f}" y1="{up(bottom)}" y2="{up(top)}" stroke="#ddd"/>')
        out.append(f'<text x="{across(power):.1f}" y="{height - 22}" text-anchor="middle">1e{power}</text>')
    for power in range(-6, top + 1, 2):
        out.append(f'<line x1="{across(left)}" x2="{across(right):.1f}" y1="{up(power):.1f}" y2="{up(power):.1f}" stroke="#ddd"/>')
        out.append(f'<text x="{margin - 4}" y="{up(power) + 3:.1f}" text-anchor="end">1e{power}</text>')
    out.append(f'<text x="{width / 2}" y="{height - 9}" text-anchor="middle">µs a step</text>')
    out.append(f'<text transform="translate(10,{height / 2}) rotate(-90)" text-anchor="middle">penetration mm</text>')
    for row, at in zip(points, x):
        depth = math.log10(min(max(row["penetration_max_mm"], floor), 1e4))
        fell = row.get("stands", row.get("held", True)) is False
        color, place = COLORS[row["engine"]], f'cx="{across(at):.1f}" cy="{up(depth):.1f}" r="{6 if row["engine"] == OWN else 4}"'
        label = f"{row['engine']} {row['variant']}: {row['us_step']:.3g} µs, {row['penetration_max_mm']:.2g} mm{', fell' if fell else ''}"
        paint = f'fill="none" stroke="{color}" stroke-width="1.5"' if fell else f'fill="{color}"'
        out.append(f"<circle {place} {paint}><title>{label}</title></circle>")
    return "".join(out)


def write(folder):
    files = {path.stem: path for path in folder.glob("S*.json")}
    results = [json.loads(files[name].read_text()) for name in SPECIAL if name in files]
    readme = HERE / "README.md"
    before, rest = readme.read_text().split(BEGIN)
    machine = results[0]["machine"]
    head = f"Measured {machine['date']} on {machine['processor']} ({machine['cores']} cores shared with others, load {machine['load_at_the_end']} at the end), {machine['system']}. "
    versions = sorted({f"{row['engine']} {row['version']}" for result in results for row in result["rows"] if row.get("version")})
    head += "Versions: " + ", ".join(versions) + ".\n"
    text = "\n".join([BEGIN, head, overview(results), *map(table, results)])
    readme.write_text(before + text + END + rest.split(END)[1])
    (folder / "speed.svg").write_text(plot(results))


if __name__ == "__main__":
    write(HERE / "results")
