"""Do plastic bricks hold together? Judges brick lists of StableLego (R. Liu and others, 2024).

python stable_lego.py stair_19.json --library lego_library.json

Every stud bears a tension. The two defaults are chosen so that the five published verdicts come out, which five other verdicts
could contradict: they are no measurement. Bricks on the lowest level are fixed. Without a file a stair of 19 bricks is judged.
"""

import argparse
import json
from typing import Dict, List, Tuple

import signorini

PITCH, HEIGHT = 0.008, 0.0096
FACES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]

Brick = Dict[str, int]
Box = Tuple[List[int], List[int]]


def stair(count: int = 19) -> Dict[str, Brick]:
    """Bricks of 2 by 4 studs, each half over the one below."""
    return {str(k): {"x": 2 * k, "y": 0, "z": k, "ori": 1, "brick_id": 2} for k in range(count)}


def studs_of(brick: Brick, library: Dict[str, Dict[str, float]]) -> Box:
    """First stud and number of studs along x and y."""
    kind = library[str(brick["brick_id"])]
    size = [int(kind["width"]), int(kind["height"])]
    return [brick["x"], brick["y"]], size if brick["ori"] == 1 else size[::-1]


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("file", nargs="?")
    arguments.add_argument("--library")
    arguments.add_argument("--tension", type=float, default=1.7, help="N that a stud bears")
    arguments.add_argument("--narrow", type=float, default=3.9, help="the same where a brick is one stud wide, N")
    given = arguments.parse_args()
    library = {"2": {"height": 2, "width": 4, "mass": 0.00216}}
    if given.library:
        with open(given.library, encoding="utf-8") as file:
            library = json.load(file)
    bricks = stair()
    if given.file:
        with open(given.file, encoding="utf-8") as file:
            bricks = json.load(file)
    lowest = min(brick["z"] for brick in bricks.values())
    assembly = signorini.Assembly(touching=1e-7)
    for name, brick in bricks.items():
        (x, y), (across, deep) = studs_of(brick, library)
        corners = [[(x + across * (k & 1)) * PITCH, (y + deep * (k >> 1 & 1)) * PITCH, (brick["z"] + (k >> 2)) * HEIGHT]
                   for k in range(8)]
        density = library[str(brick["brick_id"])]["mass"] / (across * deep * PITCH * PITCH * HEIGHT)
        assembly.add(name, corners, FACES, density=density, fixed=brick["z"] == lowest)
    for below, lower in bricks.items():
        for above, upper in bricks.items():
            if upper["z"] != lower["z"] + 1:
                continue
            (corner, size), (other, more) = studs_of(lower, library), studs_of(upper, library)
            ranges = [range(max(corner[i], other[i]), min(corner[i] + size[i], other[i] + more[i])) for i in (0, 1)]
            points = [[(i + 0.5) * PITCH, (j + 0.5) * PITCH, upper["z"] * HEIGHT] for i in ranges[0] for j in ranges[1]]
            if points:
                tension = given.narrow if min(*size, *more) == 1 else given.tension
                assembly.join(below, above, points, (0, 0, 1), tension=tension, friction=1.0)
    found = assembly.stability(enumeration=0)
    print(f"{len(assembly)} bricks, {len(found.points)} contact points: {found.verdict}, residuals {found.residuals}")
    if found.verdict != "must_move":
        pull = max(0.0, -min(force for force, in found.forces[:, 2:3]))
        limit = assembly.safety(what="tilt", direction=(1, 0, 0))
        print(f"  a balance pulls at a stud by {pull:.3f} N; held on a table tilted by {limit.holds:.6f} rad")


if __name__ == "__main__":
    main()
