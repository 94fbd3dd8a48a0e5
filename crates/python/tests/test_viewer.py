"""Runs and recordings in the browser and in notebooks."""

import html.parser
import time
import urllib.error
import urllib.request

import numpy as np
import pytest

import signorini
from signorini import viewer


def test_the_page_is_served_with_its_token_only(ball):
    data = signorini.Data(ball)
    with viewer.launch(ball, data, open_browser=False, paused=True, title="<my ball>") as shown:
        with urllib.request.urlopen(shown.url) as answer:
            page = answer.read().decode()
        assert "&lt;my ball&gt;" in page and '"live":true' in page
        origin, token = shown.url.rstrip("/").rsplit("/", 1)
        assert origin.startswith("http://127.0.0.1:") and len(token) == 32
        with pytest.raises(urllib.error.HTTPError, match="403"):
            urllib.request.urlopen(f"{origin}/{token[::-1]}/")
        assert shown.is_open and shown.url in repr(shown)
    assert not shown.is_open and "closed" in repr(shown)
    shown.close()
    with pytest.raises(RuntimeError, match="launch another"):
        shown.url
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(f"{origin}/{token}/")


def test_it_runs_a_copy_and_gives_its_state_back(ball):
    data = signorini.Data(ball)
    data.qpos[2], data.qvel[0], data.time = 0.5, 0.25, 3.0
    with viewer.launch(ball, data, open_browser=False) as shown:
        signorini.step(ball, data, nstep=10)
        # Nobody looks, so nothing runs.
        shown.sync()
        assert data.time == 3.0 and data.qpos[2] == 0.5 and data.qvel[0] == 0.25
        assert np.array_equal(data.body("ball").xpos, data.qpos[:3])


def test_errors_say_what_to_do(ball, slope):
    data = signorini.Data(ball)
    with pytest.raises(ValueError, match="data.model"):
        viewer.launch(slope, data, open_browser=False)
    with pytest.raises(signorini.SettingError, match="speed = -1"):
        viewer.launch(ball, data, open_browser=False, speed=-1.0)
    with viewer.launch(ball, data, open_browser=False) as shown:
        port = int(shown.url.split(":")[2].split("/")[0])
        with pytest.raises(OSError, match=f"{port}.*another port"):
            viewer.launch(ball, data, open_browser=False, port=port)


def test_wait_ends_when_it_is_closed(ball):
    import threading

    shown = viewer.launch(ball, signorini.Data(ball), open_browser=False)
    closing = threading.Timer(0.2, shown.close)
    closing.start()
    begin = time.monotonic()
    shown.wait()
    assert time.monotonic() - begin > 0.1 and not shown.is_open
    closing.join()


class _Frames(html.parser.HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found = []

    def handle_starttag(self, tag, attributes):
        self.found.append((tag, dict(attributes)))


def test_a_recording_in_a_notebook_is_the_whole_report_in_a_frame(ball):
    data = signorini.Data(ball)
    with data.record() as recorder:
        signorini.step(ball, data, nstep=3)
    shown = viewer.html(recorder.recording, title='a "quoted" & <bold> title', height=321)
    parser = _Frames()
    parser.feed(shown._repr_html_())
    [(tag, attributes)] = parser.found
    assert tag == "iframe" and attributes["sandbox"] == "allow-scripts" and "321px" in attributes["style"]
    assert attributes["srcdoc"] == recorder.recording.to_html(title='a "quoted" & <bold> title', max_frames=500)
    assert "3 frames" in repr(shown) or "4 frames" in repr(shown)
    assert "<iframe" in recorder.recording._repr_html_()
