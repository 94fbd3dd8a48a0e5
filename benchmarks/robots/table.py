"""Prints what `corpus.py` measured: a table of all files, sums, failures by cause, and how robots stand."""

import collections
import math
import re
import statistics

HEAD = ["file", "dof", "geoms", "left out", "load s", "contacts", "missed", "end", "µs", "MuJoCo µs", "its contacts", "ratio"]
# A median step of MuJoCo below this is the cost of a call.
LEAST_MICROSECONDS = 0.5


def print_all(rows):
    print_table(HEAD, [cells(row) for row in rows])
    print_sums(rows)
    print_failures(rows)
    print_standing(rows)


def print_table(head, rows):
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(row) + " |")


def short(path):
    """The path within its collection."""
    parts = re.split(r"/(?:packages|mirror|un)/", path, maxsplit=1)
    return parts[-1].replace("cmeel.prefix/share/example-robot-data/robots/", "")


def good(row):
    return row["own"]["end"] == "finished" and not row["own"].get("missed", 0)


def refused_by_both(row):
    return row["own"]["end"] == "refused" and row.get("mujoco", {}).get("end") == "refused"


def ratio(row):
    """Our median step over MuJoCo's; None where one did not run, or nothing moves."""
    own, peer = row["own"], row.get("mujoco", {})
    if not good(row) or peer.get("end") != "finished" or not own["nv"] or peer["median_us"] < LEAST_MICROSECONDS:
        return None
    return own["median_us"] / peer["median_us"]


def left_out(own):
    words = {}
    for line in own.get("left_out", []):
        # FILE:LINE: <element> what: effect
        match = re.search(r"<([\w:]+)>.*?(?:['(]([\w:]+)['(]|:|$)", line)
        if match:
            words[f"{match[1]} {match[2] or ''}".strip()] = None
    return ", ".join(list(words)[:6]) + (", …" if len(words) > 6 else "")


def cells(row):
    own, peer = row["own"], row.get("mujoco", {})
    end = own["end"] + (f": {shorten(own['message'], row)}" if own.get("message") else "")
    number = lambda result, key, form: format(result[key], form) if key in result else ""
    relative = ratio(row)
    return [
        short(row["file"]), number(own, "nv", "d"), number(own, "geoms", "d"), left_out(own), number(own, "load_s", ".2f"),
        number(own, "contacts_max", "d"), number(own, "missed", "d"), end, number(own, "median_us", ".0f"),
        number(peer, "median_us", ".0f") if peer.get("end") != "refused" else "refused", number(peer, "contacts_max", "d"),
        f"{relative:.2f}" if relative else "",
    ]  # fmt: skip


def shorten(message, row):
    folder = row["file"].rsplit("/", 1)[0] + "/"
    return " ".join(message.replace(folder, "").split())[:200].replace("|", "/")


def print_sums(rows):
    ran, faulty = sum(map(good, rows)), sum(map(refused_by_both, rows))
    loaded = sum("load_s" in row["own"] for row in rows)
    print(f"\n{len(rows)} complete files, {loaded} loaded, {ran} ran to the end without a missed step ({share(ran, len(rows))});")
    print(f"of those that MuJoCo takes, or cannot be asked about, {share(ran, len(rows) - faulty)} ({faulty} are refused by both)")
    ratios = sorted(r for r in map(ratio, rows) if r)
    if ratios:
        at = lambda q: ratios[round(q * (len(ratios) - 1))]
        print(f"time of a step beside MuJoCo's: {len(ratios)} files, median {at(0.5):.2f}, 95 % at most {at(0.95):.2f}, "
              f"worst {ratios[-1]:.2f}, at most 1.5 in {share(sum(r <= 1.5 for r in ratios), len(ratios))}")  # fmt: skip


def share(part, whole):
    return f"{100 * part / max(whole, 1):.1f} %"


def cause(row):
    """The message without names and numbers, so that the same fault in several files is one."""
    own = row["own"]
    message = re.sub(r"^\S+:\d+:\d+: ", "", own.get("message", ""))
    message = re.sub(r"'[^']*'|\"[^\"]*\"", "'…'", message)
    message = re.sub(r"\S*/\S+", "…", message)
    message = re.sub(r"-?\d+(\.\d+)?(e-?\d+)?", "#", message)
    message = "" if own["end"] == "no solution" else message
    missed = "missed steps " if own["end"] == "finished" else ""
    return " ".join(f"{missed or own['end']}: {message}".split())[:160]


def print_failures(rows):
    causes = collections.defaultdict(list)
    for row in rows:
        if not good(row):
            causes[cause(row)].append(row)
    for name, group in sorted(causes.items(), key=lambda item: -len(item[1])):
        print(f"\n### {name} ({len(group)})\n")
        for row in group:
            own, peer = row["own"], row.get("mujoco", {})
            time = f", t = {own['time']:.3f} s of {own['timestep']:g}" if "time" in own else ""
            missed = f", {own['missed']} missed of {own['steps']}, worst {own['worst'] or math.nan:.1e}" if own.get("missed") else ""
            deep = f", {own['deepest_mm']:.1f} mm deep" if own.get("deepest_mm", 0) > 0.05 else ""
            where = f" [{shorten(own['message'], row)}]" if own.get("message") else ""
            print(f"- {short(row['file'])}{time}{missed}{deep}{where}" + (" MuJoCo: " + peer["end"] if peer else ""))


def distance(a, b):
    """Largest distance (mm) and angle (degrees) between the bodies of the same name."""
    far, turned = 0.0, 0.0
    for name in a.keys() & b.keys():
        p, q = a[name], b[name]
        far = max(far, 1e3 * math.dist(p[:3], q[:3]))
        cosine = abs(sum(x * y for x, y in zip(p[3:], q[3:], strict=True)))
        turned = max(turned, math.degrees(2 * math.acos(min(1.0, cosine))))
    return far, turned


def print_standing(rows):
    """Robots with servos and a keyframe `home`: how far either engine ends from it, and from the other."""
    stand = [r for r in rows if r["keyframe"] == "home" and r["servos"] and good(r) and r.get("mujoco", {}).get("poses")]
    if not stand:
        return
    print("\nFrom the keyframe `home`, after the run:\n")
    lines, agree = [], 0
    for row in stand:
        own, peer = row["own"], row["mujoco"]
        moved, moved_there = distance(own["start"], own["poses"]), distance(peer["start"], peer["poses"])
        apart = distance(own["poses"], peer["poses"])
        agree += apart[0] <= 1.0 and apart[1] <= 0.5
        pair = lambda values: f"{values[0]:.2f} mm, {values[1]:.2f}°"
        lines.append([short(row["file"]), pair(moved), pair(moved_there), pair(apart)])
    print_table(["robot", "moved", "in MuJoCo", "apart"], lines)
    worst = statistics.median(distance(r["own"]["poses"], r["mujoco"]["poses"])[0] for r in stand)
    print(f"\n{agree} of {len(stand)} within 1 mm and 0.5° of MuJoCo; median {worst:.3f} mm")
