"""What is said while kernels are compiled, in the terminal and on the dashboard."""

import contextlib

import pytest

import mossar_stream
from mossar_adapters.pipeline import Pipeline
from mossar_adapters.source import Meta
from mossar_stream import Settings, Skeleton
from mossar_tools.compiling import Compiling, reporting_compilation
from mossar_tools.dashboard.live import LiveShow
from mossar_tools.dashboard.tables import WAITING, state_card


def card(show):
    return state_card(show.glimpses(), frozen=False, recording="", frames=0, waits_for=show.waits_for)


def test_the_dashboard_says_that_kernels_are_compiled_and_then_waits_for_frames():
    show = LiveShow(Settings())
    said = Compiling(show.say)
    said.begin()
    said.part("decisions", 0, 2)
    assert "compiling kernels: decisions, part 1 of 2" in card(show)
    said.end()
    assert WAITING in card(show)


def test_what_ctrl_c_interrupts_is_not_called_compiled(monkeypatch, caplog):
    texts = []

    def interrupted(*_, progress, **__):
        progress("decisions", 0, 2)
        raise KeyboardInterrupt

    def told(begin):
        begin()
        return contextlib.nullcontext()

    monkeypatch.setattr(mossar_stream, "on_first_compile", told)
    monkeypatch.setattr(mossar_stream, "precompile", interrupted)
    with caplog.at_level("INFO"), pytest.raises(KeyboardInterrupt), reporting_compilation(tell=texts.append):
        pass
    assert any("compiling kernels: decisions, part 1 of 2" in text for text in texts)
    assert texts[-1] == ""
    assert "kernels compiled" not in caplog.text


@pytest.mark.parametrize("name", ["there_is_none.bvh", "text.mp4", "empty.c3d"])
def test_nothing_is_compiled_for_a_file_that_cannot_be_read(mossar, monkeypatch, tmp_path, name):
    compiled = []
    monkeypatch.setattr(mossar_stream, "precompile", lambda *_, **__: compiled.append(1))
    path = tmp_path / name
    if name != "there_is_none.bvh":
        path.write_bytes(b"no motion" * (name == "text.mp4"))
    status, _, err = mossar("segment", path)
    assert status == 2
    assert name in err
    assert not compiled


class Empty:
    """A live source that knows why nothing comes."""

    name = "webcam:"
    live = True

    def items(self):
        for _ in range(40):
            yield None

    def explain(self):
        return "webcam: 7 pictures came without a <person>"

    def close(self):
        pass


def test_the_dashboard_says_what_a_source_knows_of_why_nobody_is_seen(monkeypatch):
    show, times = LiveShow(Settings()), iter(range(1000))
    monkeypatch.setattr("mossar_tools.dashboard.live.time.monotonic", lambda: float(next(times)))
    pipeline = Pipeline([Empty()], [], Settings(), views=[show])
    show.tick(pipeline)
    assert WAITING in card(show)  # not yet: a source may need a moment
    show.tick(pipeline)
    assert "7 pictures came without a &lt;person&gt;" in card(show)
    show.announce(Meta("p1", Skeleton(("hip", "hand"), (-1, 0))))
    show.say("")
    show.tick(pipeline)
    assert WAITING in card(show)
