"""Does an assembly of COMPAS stand?

python compas.py assembly.json --supports 0,1 --friction 0.9 --density 1 --touching 1e-3

Where no supports are named they are the blocks that the file marks (is_support), and the first one where it marks none. Without a file an arch of 15 voussoirs is judged.
"""

import argparse
import json
import math
from typing import Any, Dict, Iterator, List, Tuple

import signorini

Surface = Tuple[str, List[List[float]], List[List[int]]]


def nodes_of(path: str) -> Dict[str, Any]:
    """The nodes of a JSON file of COMPAS by their names."""
    with open(path, encoding="utf-8") as file:
        return dict(json.load(file)["data"]["graph"]["data"]["node"])


def blocks_of(nodes: Dict[str, Any]) -> Iterator[Surface]:
    """Name, vertices and faces of every block."""
    for name, node in nodes.items():
        block = node["block"]["data"]
        places = {key: k for k, key in enumerate(block["vertex"])}
        vertices = [[v["x"], v["y"], v["z"]] for v in block["vertex"].values()]
        yield name, vertices, [[places[str(key)] for key in face] for face in block["face"].values()]


def arch(count: int = 15, thickness: float = 0.15) -> Iterator[Surface]:
    """Voussoirs of a semicircle of mean radius 1 m, between two supports."""
    faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    for k in range(-1, count + 1):
        ends = [math.pi * (k + i) / count for i in (0, 1)]
        corners = [(r * math.cos(a), r * math.sin(a)) for a, r in
                   [(ends[0], 1 - thickness / 2), (ends[0], 1 + thickness / 2),
                    (ends[1], 1 + thickness / 2), (ends[1], 1 - thickness / 2)]]
        yield str(k), [[x, y, z] for y in (0, 0.2) for x, z in corners], faces


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("file", nargs="?")
    arguments.add_argument("--supports", default=None, help="names of fixed blocks, with commas between")
    arguments.add_argument("--friction", type=float, default=0.84)
    arguments.add_argument("--density", type=float, default=1000.0)
    arguments.add_argument("--touching", type=float, default=1e-6)
    given = arguments.parse_args()
    nodes = nodes_of(given.file) if given.file else {}
    blocks = list(blocks_of(nodes) if given.file else arch())
    marked = [name for name, node in nodes.items() if node.get("is_support")]
    default = (marked or [min(nodes)]) if given.file else ["-1", "15"]
    supports = given.supports.split(",") if given.supports else default
    assembly = signorini.Assembly(touching=given.touching)
    for name, vertices, faces in blocks:
        assembly.add(name, vertices, faces, density=given.density, friction=given.friction, fixed=name in supports)
    found = assembly.stability()
    print(f"{len(assembly)} blocks on {', '.join(supports)}, {len(found.points)} contact points: {found.verdict}")
    print(f"  residuals of the proof: {found.residuals}")
    if found.verdict == "must_move":
        print(f"  {len(found.motion)} blocks move in the collapse: {', '.join(found.motion)}")
    else:
        print(f"  friction used: {100 * found.friction_use.max():.0f} % at most")
        tilt = assembly.safety(what="tilt", direction=(1, 0, 0))
        print(f"  forces balance its weight on a table tilted by up to {math.degrees(tilt.holds):.6f}°")


if __name__ == "__main__":
    main()
