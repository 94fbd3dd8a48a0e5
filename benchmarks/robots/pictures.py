"""Takes pictures of twenty robots with `signorini render` and puts them into one, docs/src/images/robots.jpg.

    python3 benchmarks/robots/pictures.py [FOLDER ...] [--program target/release/signorini]

Needs Pillow, the packages that corpus.py has fetched, and for some of the robots folders with checkouts of kevinzakka/mink and
osrf/gazebo_models. The models belong to their authors.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

from PIL import Image, ImageDraw

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
PACKAGES = REPOSITORY / "build" / "corpus" / "packages"
TARGET = REPOSITORY / "docs" / "src" / "images" / "robots.jpg"
SIDE, LINE, COLUMNS = 200, 16, 5
MINK, ROBOSUITE = "examples/", "robosuite/models/assets/robots/"
# The shapes that robosuite's robots collide with are group 0.
VISUAL = ["--groups", "1"]
ROBOTS = [
    ("Unitree G1", MINK + "unitree_g1/scene.xml", []),
    ("Unitree H1", MINK + "unitree_h1/scene.xml", []),
    ("Fourier GR1", ROBOSUITE + "gr1/robot.xml", []),
    ("PR2", "pr2/model.sdf", ["--floor"]),
    ("Baxter", ROBOSUITE + "baxter/robot.xml", []),
    ("ALOHA", MINK + "aloha/scene.xml", []),
    ("TidyBot", MINK + "stanford_tidybot/scene.xml", []),
    ("Fetch", "gymnasium_robotics/envs/assets/fetch/pick_and_place.xml", []),
    ("Sawyer (Meta-World)", "metaworld/assets/sawyer_xyz/sawyer_drawer.xml", []),
    ("Sawyer", ROBOSUITE + "sawyer/robot.xml", VISUAL),
    ("Panda", ROBOSUITE + "panda/robot.xml", VISUAL),
    ("UR5e", ROBOSUITE + "ur5e/robot.xml", VISUAL),
    ("iiwa 14", MINK + "kuka_iiwa_14/scene.xml", []),
    ("xArm 7", MINK + "ufactory_xarm7/scene.xml", []),
    ("Kinova Gen3", ROBOSUITE + "kinova3/robot.xml", []),
    ("Spot", ROBOSUITE + "spot/robot.xml", VISUAL),
    ("Shadow hand", MINK + "shadow_hand/scene_left.xml", []),
    ("Shadow hand with egg", "gymnasium_robotics/envs/assets/hand/manipulate_egg.xml", []),
    ("rodent", "dm_control/locomotion/walkers/assets/rodent.xml", []),
    ("fruit fly", "dm_control/locomotion/walkers/assets/fruitfly_v2/fruitfly.xml", []),
]


def find(name, folders):
    """The file whose path ends so."""
    for folder in folders:
        for place in (folder, *(child for child in folder.iterdir() if child.is_dir())):
            if (place / name).is_file():
                return place / name
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", type=pathlib.Path)
    parser.add_argument("--program", type=pathlib.Path, default=REPOSITORY / "target" / "release" / "signorini")
    options = parser.parse_args()
    folders = [*options.folders, *sorted(folder for folder in PACKAGES.iterdir() if folder.is_dir())]
    rows = -(-len(ROBOTS) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * SIDE, rows * (SIDE + LINE)), "white")
    draw = ImageDraw.Draw(sheet)
    with tempfile.TemporaryDirectory() as scratch:
        picture = pathlib.Path(scratch) / "robot.png"
        for k, (name, path, extra) in enumerate(ROBOTS):
            model = find(path, folders)
            if model is None:
                sys.exit(f"{name}: no file {path} in the folders")
            size = f"{2 * SIDE}x{2 * SIDE}"
            command = [options.program, "render", model, "--out", picture, "--size", size, "--samples", "16", *extra]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            place = (k % COLUMNS * SIDE, k // COLUMNS * (SIDE + LINE))
            with Image.open(picture) as image:
                sheet.paste(image.convert("RGB").resize((SIDE, SIDE), Image.Resampling.LANCZOS), place)
            draw.text((place[0] + 4, place[1] + SIDE + 2), name, fill="black")
    sheet.save(TARGET, quality=88)
    print(TARGET)


if __name__ == "__main__":
    main()
