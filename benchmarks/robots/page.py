"""The page of a report beside the picture of the renderer, from the same place: silhouettes and colours.

    python3 benchmarks/robots/page.py MODEL ... [--out FOLDER] [--browser chromium] [--size 640x480]

Every model hangs in the sky, without a floor, in its reference configuration. `overlap` is the area that the shapes cover in both pictures over
the area that they cover in either; `mean` and `95 %` are of the largest difference of red, green and blue of a pixel, of 255, where both show a
shape. Needs the Python package `signorini`, Pillow and Chromium.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile
import warnings

import numpy as np
import signorini
from PIL import Image

# A pixel of the page shows the sky where it differs from the sky by less than this, of 255.
SKY = 6
DIRECTION = 120.0, -20.0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="+", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("--browser", default="chromium")
    parser.add_argument("--size", default="640x480")
    arguments = parser.parse_args()
    size = tuple(map(int, arguments.size.split("x")))
    print("| model | overlap | mean | 95 % |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for path in arguments.models:
            rendered, shapes, sky, page = pictures(path, size, pathlib.Path(folder), arguments.browser)
            if arguments.out:
                arguments.out.mkdir(parents=True, exist_ok=True)
                both = Image.fromarray(np.hstack([rendered, page]))
                both.save(arguments.out / f"{path.parent.name}-{path.stem}.png")
            seen = np.abs(page.astype(int) - sky).max(axis=2) > SKY
            shown = shapes & seen
            difference = np.abs(page.astype(int) - rendered).max(axis=2)[shown]
            overlap = shown.sum() / max((shapes | seen).sum(), 1)
            print(f"| {path.parent.name}/{path.name} | {overlap:.4f} | {difference.mean():.1f} | {np.quantile(difference, 0.95):.0f} |", flush=True)


def pictures(path, size, folder, browser):
    """The renderer's picture, where it has shapes, the sky alone, and the page's picture, (h, w, 3) and (h, w)."""
    warnings.simplefilter("ignore")
    model = signorini.Model.from_file(path)
    spec = signorini.Spec(model)
    planes = [name for name in spec.names("geom") if spec.geom(name).type == "plane"]
    for name in planes:
        spec.remove("geom", name)
    model = spec.compile() if planes else model
    data = signorini.Data(model)
    renderer = signorini.Renderer(model, *size)
    view = renderer.framing(data, *DIRECTION)
    rendered, shapes = renderer.render(data, view), renderer.segmentation(data, view) >= 0
    empty = signorini.Model.from_string("<mujoco/>")
    sky = signorini.Renderer(empty, *size).render(signorini.Data(empty), view).astype(int)
    report, shot = folder / "report.html", folder / "shot.png"
    with data.record() as recorder:
        signorini.step(model, data)
    recorder.recording.to_html(report)
    numbers = ",".join(f"{x:.9g}" for x in [*view.position, *view.quat, np.radians(view.fovy)])
    command = [browser, "--headless", "--no-sandbox", "--hide-scrollbars", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    command += [f"--window-size={size[0]},{size[1]}", "--virtual-time-budget=8000", f"--screenshot={shot}"]
    subprocess.run([*command, f"file://{report}#picture&view={numbers}"], check=True, capture_output=True)
    return rendered, shapes, sky, np.array(Image.open(shot).convert("RGB"))


if __name__ == "__main__":
    sys.exit(main())
