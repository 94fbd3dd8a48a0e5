"""An arm with the Panda's joints picks three cubes and stacks them: exact contact, every step certified.

    python pick_and_stack.py [FILM.mp4]

Grasps hold by dry friction alone: nothing is glued to the hand.
"""

import pathlib
import sys
from typing import Optional

import numpy as np
from numpy.typing import ArrayLike

import signorini

MODELS = pathlib.Path(__file__).parent / "models"
EDGE = 0.04
DOWN = (0.0, 1.0, 0.0, 0.0)
HOME = (0.0, -0.6, 0.0, -2.2, 0.0, 1.6, 0.8)


def build() -> signorini.Model:
    """The arm, a table and three cubes."""
    world = signorini.scene("pick and stack")
    world.floor(friction=0.8)
    world.load(MODELS / "arm.xml", prefix="arm ")
    for k, place in enumerate([(0.45, -0.2), (0.55, 0.0), (0.45, 0.2)]):
        color = [(0.8, 0.2, 0.2, 1), (0.2, 0.6, 0.3, 1), (0.2, 0.3, 0.8, 1)][k]
        half = (EDGE / 2,) * 3
        world.box(half, pos=(*place, EDGE / 2), mass=0.1, friction=0.8, rgba=color, name=f"cube {k}")
    return world.compile()


class Arm:
    """Moves the hand in straight lines by inverse kinematics and servos."""

    def __init__(self, model: signorini.Model, data: signorini.Data, film: Optional[signorini.Film] = None) -> None:
        self.model, self.data, self.film = model, data, film
        self.renderer = signorini.Renderer(model, 640, 360) if film is not None else None
        self.joints = [f"arm joint{k}" for k in range(1, 8)]
        data.ctrl[:] = [*HOME, 0.04]
        data.qpos[:7] = HOME

    def wait(self, seconds: float) -> None:
        for _ in range(max(1, round(30 * seconds))):
            signorini.step(self.model, self.data, nstep=round(1 / 30 / self.model.timestep))
            if self.film is not None and self.renderer is not None:
                self.film.add(self.renderer.render(self.data, signorini.View.orbit([0.4, 0, 0.2], 1.6, 150, -20)))

    def move(self, goal: ArrayLike, seconds: float) -> None:
        """The hand goes to a place with its fingers down."""
        signorini.kinematics(self.model, self.data)
        start, _ = signorini.frame_pose(self.model, self.data, site="arm grip")
        steps = round(30 * seconds)
        for k in range(1, steps + 1):
            s = k / steps
            place = start + (np.array(goal) - start) * s * s * (3 - 2 * s)
            found = signorini.inverse_kinematics(self.model, self.data, place, DOWN, site="arm grip", joints=self.joints)
            self.data.ctrl[:7] = found.qpos[:7]
            self.wait(1 / 30)

    def grip(self, width: float) -> None:
        self.data.ctrl[7] = width
        self.wait(0.5)


def stack(model: signorini.Model, data: signorini.Data, film: Optional[signorini.Film] = None) -> None:
    """Puts the cubes 0 and 2 on cube 1."""
    arm = Arm(model, data, film)
    arm.wait(0.2)
    x, y, _ = data.body("cube 1").xpos
    for level, cube in enumerate([0, 2], start=1):
        at = np.array(data.body(f"cube {cube}").xpos)
        above = np.array([0, 0, 0.12])
        arm.move(at + above, 1.0)
        arm.move(at, 0.7)
        arm.grip(0.0)
        arm.move(at + above, 0.7)
        goal = np.array([x, y, EDGE * (level + 0.5) + 0.001])
        arm.move(goal + above, 1.2)
        arm.move(goal, 0.8)
        arm.grip(0.04)
        arm.move(goal + above, 0.7)
    arm.wait(0.5)


if __name__ == "__main__":
    model = build()
    data, film = signorini.Data(model), signorini.Film(640, 360, fps=30) if len(sys.argv) > 1 else None
    stack(model, data, film)
    heights = [float(data.body(f"cube {k}").xpos[2]) for k in (1, 0, 2)]
    print(f"after {data.time:.1f} s the cubes are at {np.round(heights, 4)} m; steps that missed the tolerance: {data.missed_steps}")
    if film is not None:
        film.save(sys.argv[1])
