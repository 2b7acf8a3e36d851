"""Progress bars of long recordings: on a terminal only, once the work has taken two seconds, and no obstacle to Ctrl-C."""

import io
import logging

import numpy as np
import pytest

from mossar_adapters.demo import performance
from mossar_stream import Settings, segment_recording
from mossar_stream.recording import recording as recordings
from mossar_tools import console as consoles
from mossar_tools.cli import main
from mossar_tools.console import LOGGER, PROGRESS, Console, progress_of


class Terminal(io.StringIO):
    encoding = "utf-8"

    def __init__(self, *, is_terminal=True):
        super().__init__()
        self._is_terminal = is_terminal

    def isatty(self):
        return self._is_terminal


@pytest.fixture(autouse=True)
def loggers():
    before = [(logger, logger.handlers[:], logger.level, logger.propagate) for logger in (LOGGER, PROGRESS)]
    yield
    for logger, handlers, level, propagate in before:
        logger.handlers[:], logger.propagate = handlers, propagate
        logger.setLevel(level)


@pytest.fixture(autouse=True)
def short_pieces(monkeypatch):
    monkeypatch.setattr(recordings, "PIECE", 150)


@pytest.fixture(scope="module")
def take():
    shown = performance(1, fps=30.0, seconds=20.0)
    return shown.skeleton, np.array(shown.frames.positions)


@pytest.fixture
def recording(take, tmp_path):
    skeleton, frames = take
    path = tmp_path / "long.npz"
    np.savez(path, positions=frames, fps=30.0, joint_names=skeleton.names, parents=skeleton.parents)
    return str(path)


@pytest.mark.parametrize("range_", ["file", "running"])
@pytest.mark.parametrize("limbs", [False, True])
@pytest.mark.parametrize("takes", [False, True])
def test_the_share_of_a_recording_rises_to_all_of_it(take, range_, limbs, takes):
    skeleton, frames = take
    shares = []
    settings = Settings(range=range_, limbs=limbs)
    result = segment_recording(frames, 30, skeleton, settings, takes=takes, on_progress=shares.append)
    assert shares == sorted(shares)
    assert len(shares) >= len(frames) // 150
    assert 0.0 < shares[0] < 1.0
    assert shares[-1] == 1.0
    plain = segment_recording(frames, 30, skeleton, settings, takes=takes)
    assert (result.key_frames, result.segments) == (plain.key_frames, plain.segments)


def test_ctrl_c_acts_between_two_pieces(take):
    skeleton, frames = take
    shares = []

    def interrupted(share):
        shares.append(share)
        if len(shares) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        segment_recording(frames, 30, skeleton, on_progress=interrupted)
    assert len(shares) == 2


def segmented(monkeypatch, arguments, *, is_terminal, patience=0.0):
    out, err = Terminal(is_terminal=False), Terminal(is_terminal=is_terminal)
    monkeypatch.setattr(consoles, "_PATIENCE", patience)
    monkeypatch.setattr(consoles, "_STATUS_PERIOD", 0.0)
    monkeypatch.setattr(consoles, "console", lambda: Console(out, err))
    monkeypatch.setattr("mossar_tools.cli.console", lambda: Console(out, err), raising=False)
    status = main(["segment", *arguments])
    return status, out.getvalue(), err.getvalue()


def test_a_bar_is_shown_on_a_terminal_and_removed_before_the_results(monkeypatch, recording):
    status, out, err = segmented(monkeypatch, [recording], is_terminal=True)
    assert status == 0
    bars = [line for line in err.split("\r") if "segmenting" in line]
    assert any("100%" in line for line in bars)
    assert "segmenting" not in err.split("\r")[-1]
    assert "segment" in out
    assert "100%" not in out


@pytest.mark.parametrize(
    ("is_terminal", "patience", "more"), [(False, 0.0, []), (True, 60.0, []), (True, 0.0, ["--quiet"])]
)
def test_no_bar_without_a_terminal_of_short_work_and_with_quiet(
    monkeypatch, recording, is_terminal, patience, more
):
    status, _, err = segmented(monkeypatch, [recording, *more], is_terminal=is_terminal, patience=patience)
    assert status == 0
    assert "segmenting" not in err


def test_work_that_lasts_longer_than_the_patience_is_shown(monkeypatch):
    moments = iter([10.0, 11.9, 12.1])
    monkeypatch.setattr(consoles.time, "monotonic", lambda: next(moments))
    seen = []
    handler = logging.Handler()
    handler.emit = lambda record: seen.append((record.getMessage(), record.share))
    monkeypatch.setattr(PROGRESS, "handlers", [handler])
    PROGRESS.setLevel(logging.DEBUG)
    show = progress_of("segmenting walk.bvh")
    show(0.25)
    show(0.5)
    assert seen == [("segmenting walk.bvh", 0.5)]
