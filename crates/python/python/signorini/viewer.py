"""Runs and recordings in the browser and in notebooks.

>>> import signorini
>>> from signorini import viewer
>>> model = signorini.Model.from_string(
...     "<mujoco><worldbody><geom type='plane'/><body pos='0 0 1'><freejoint/><geom size='0.1'/></body></worldbody></mujoco>")
>>> with viewer.launch(model, signorini.Data(model), open_browser=False) as shown:
...     shown.url.startswith("http://127.0.0.1:")
True
"""

from __future__ import annotations

import time
import warnings
from types import TracebackType
from typing import Optional, Type

from signorini import _core
from signorini._core import Recording, kinematics
from signorini.data import Data
from signorini.model import Model

__all__ = ["InlineReport", "Viewer", "html", "launch"]


class Viewer(_core.Viewer):
    """A copy of a :class:`signorini.Data` that runs in the browser; made by :func:`launch`.

    It runs on a thread of its own and shares nothing with the data until :meth:`sync`. A ``with`` block closes it.
    """

    _data: Data

    def sync(self) -> None:
        """Writes the time, configuration and velocity that the simulation in the browser has now into the data."""
        data = self._data
        data.time, data.qpos, data.qvel = self._state()
        kinematics(data.model, data)

    def wait(self) -> None:
        """Blocks until it is closed, from another thread or by an interrupt, which is raised."""
        while self.is_open:
            time.sleep(0.1)

    def __enter__(self) -> Viewer:
        return self

    def __exit__(
        self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<signorini.viewer.Viewer at {self.url}>" if self.is_open else "<signorini.viewer.Viewer, closed>"


def launch(
    model: Model,
    data: Data,
    *,
    port: int = 0,
    open_browser: bool = True,
    paused: bool = False,
    speed: float = 1.0,
    title: str = "",
) -> Viewer:
    """Shows a simulation in the browser: run, pause, step, reset, drag bodies; forces, friction polygons, residuals.

    It begins with the state, control and applied force of ``data``, of which it takes a copy, and waits while no page is
    open. The page is served on 127.0.0.1 only, at an address with a random token.

    Args:
        model: the model of the data.
        data: where to begin.
        port: the port; 0 takes a free one.
        open_browser: whether to open the page; where that fails, a warning has the address.
        paused: whether to wait for the user to start it.
        speed: simulated seconds per second, as far as the machine can.
        title: title of the page; the model's name when empty.

    Raises:
        ValueError: the data belongs to another model.
        SettingError: the speed is out of its range.
        OSError: the port cannot be listened on.
    """
    if data.model is not model:
        raise ValueError("data belongs to another model: pass data.model")
    viewer = Viewer(data, port, title, not paused, speed)
    viewer._data = data
    if open_browser:
        try:
            viewer._open_browser()
        except OSError as error:
            warnings.warn(f"the browser could not be opened ({error}); open {viewer.url}", stacklevel=2)
    return viewer


class InlineReport:
    """A recording for a notebook, which shows it where this is the value of a cell; made by :func:`html`."""

    def __init__(self, recording: Recording, title: str, max_frames: int, height: int) -> None:
        self.recording = recording
        self._settings = (title, max_frames, height)

    def _repr_html_(self) -> str:
        return self.recording._inline_html(*self._settings)

    def __repr__(self) -> str:
        return f"<signorini.viewer.InlineReport of {self.recording!r}>"


def html(recording: Recording, *, title: str = "", max_frames: int = 500, height: int = 600) -> InlineReport:
    """A recording for a notebook: the page of ``Recording.to_html`` in a frame of its own.

    Args:
        recording: the run.
        title: title; the model's name when empty.
        max_frames: frames in the page, at most; a longer run is thinned.
        height: of the frame, CSS pixels.
    """
    return InlineReport(recording, title, max_frames, height)
