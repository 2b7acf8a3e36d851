"""Teaching in the dashboard: a countdown, one movement, examples as figures, and nothing that was taken is lost."""

import html
import os
import re
import signal
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from mossar_adapters.source import Meta
from mossar_stream import Frames, MossarError, Moves, Settings, Skeleton
from mossar_tools.dashboard.live import LiveShow
from mossar_tools.dashboard.teaching import COUNTED, PATIENCE, SHOWN, Teaching, mark_of
from mossar_tools.dashboard.teaching_view import MOST, countdown, examples_card

from .test_dashboard import address, browser, opened, press, until  # noqa: F401 - fixtures
from .test_teach import FPS, PERSON, PUNCH, RAISE, RESTING, shown

MINE = Meta("p1", PERSON)
WATCH_COUNT = """
window.counted = false
const holds = node => node.id === "mossar-count" || Boolean(node.querySelector?.("#mossar-count"))
new MutationObserver(changes => {  // the count may have gone again before a busy page looks
    window.counted ||= holds(document.body) || changes.some(change => [...change.addedNodes].some(holds))
}).observe(document.body, {childList: true, subtree: true})
"""

# The scene is not looked at here: drawn without a graphics card, on a busy machine, it leaves the page no time to show a count.
DRAW_NOTHING = """
for (const name of ["drawArrays", "drawElements", "drawArraysInstanced", "drawElementsInstanced"])
    WebGL2RenderingContext.prototype[name] = () => {}
"""


class Stage:
    """Teaching, its clock, and a stream of one performer."""

    def __init__(self, folder, path=None):
        self.now, self.time, self.changes = 0.0, 0.0, []
        self.teaching = Teaching(folder, path, self.changes.append, lambda: self.now)

    def stream(self, positions):
        times = self.time + np.arange(len(positions)) / FPS
        for at in range(0, len(times), 7):
            part = slice(at, at + 7)
            self.teaching.send_frames(Frames(positions[part].astype(np.float32), times[part], None, "p1"))
        self.time = times[-1] + 1 / FPS

    def teach(self, name, positions):
        self.teaching.begin(name, MINE)
        self.now += COUNTED
        self.stream(positions)
        return self.teaching.state


@pytest.fixture
def stage(tmp_path):
    return Stage(tmp_path)


def test_a_movement_after_the_countdown_is_on_the_disk_before_it_is_said(stage, tmp_path):
    state = stage.teach("punch", shown(PUNCH))
    assert state.phase == "taken"
    assert "punch: example 1 taken" in state.message
    assert "moves-1.json" in state.message
    assert Moves.load(tmp_path / "moves-1.json").names == ("punch",)
    assert stage.teach("punch", shown(PUNCH)).message.startswith("punch: example 2")
    assert stage.teach("raise", shown(RAISE)).message.startswith("raise: example 1")
    assert Moves.load(tmp_path / "moves-1.json").examples == stage.changes[-1].examples
    assert [len(moves) for moves in stage.changes] == [1, 2, 3]
    stage.now += SHOWN
    assert stage.teaching.state.phase == "idle"


def test_what_moves_during_the_countdown_and_without_it_is_not_taken(stage, tmp_path):
    stage.stream(shown(PUNCH))
    stage.teaching.begin("punch", MINE)
    stage.stream(shown(PUNCH))
    assert (stage.teaching.state.phase, stage.teaching.state.seconds) == ("count", COUNTED)
    stage.now += 1.5
    assert stage.teaching.state.seconds == COUNTED - 1
    slow = np.repeat(RESTING[None], 150, axis=0)  # still at it when the time comes
    slow[:, 2, 0] += np.linspace(0.0, 3.0, 150)
    stage.stream(slow[:100])
    stage.now += COUNTED
    stage.stream(np.concatenate([slow[100:], shown()]))
    assert stage.teaching.state.phase == "watch"
    assert list(tmp_path.iterdir()) == []
    stage.stream(shown(PUNCH))
    assert len(stage.teaching.moves) == 1


def test_who_waits_too_long_or_changes_their_mind_takes_nothing(stage, tmp_path):
    state = stage.teach("punch", np.repeat(RESTING[None], 60, axis=0))
    assert (state.phase, state.runs) == ("watch", True)
    stage.now += PATIENCE
    assert stage.teaching.state.phase == "failed"
    assert "no movement" in stage.teaching.state.message
    stage.stream(shown(PUNCH))
    stage.teaching.begin("punch", MINE)
    stage.teaching.cancel()
    stage.now += COUNTED
    stage.stream(shown(PUNCH))
    assert stage.teaching.state.phase == "idle"
    assert list(tmp_path.iterdir()) == []


def test_a_hidden_joint_is_where_it_was_before_the_countdown(stage, tmp_path):
    stage.teaching.announce(MINE)
    stage.stream(np.repeat(RESTING[None], 10, axis=0))
    hidden = shown(PUNCH)
    hidden[:, 2] = 5.0  # where the sensor guesses it to be
    confidence = np.ones(len(PERSON), np.float32)
    confidence[2] = 0.0
    stage.teaching.begin("punch", MINE)
    stage.now += COUNTED
    times = stage.time + np.arange(len(hidden)) / FPS
    sure = np.repeat(confidence[None], len(hidden), axis=0)
    stage.teaching.send_frames(Frames(hidden.astype(np.float32), times, sure, "p1"))
    assert stage.teaching.state.phase == "taken", stage.teaching.state.message
    (example,) = Moves.load(tmp_path / "moves-1.json").examples
    placed = example.metres(len(PERSON)) - example.metres(len(PERSON))[:, :1]
    assert np.allclose(placed[:, 2], RESTING[2] - RESTING[0], atol=1e-3)


def test_one_unlike_the_others_is_asked_for_again_and_may_be_kept(stage, tmp_path):
    stage.teach("punch", shown(PUNCH))
    state = stage.teach("punch", shown(RAISE))
    assert (state.phase, state.runs, state.can_keep) == ("again", True, True)
    assert state.message == "not kept: punch: example 2 is another movement than the others"
    assert "press Keep" in countdown(state)
    assert len(Moves.load(tmp_path / "moves-1.json")) == 1
    stage.stream(shown(PUNCH))
    assert (stage.teaching.state.phase, stage.teaching.state.can_keep) == ("taken", False)
    assert len(Moves.load(tmp_path / "moves-1.json")) == 2
    stage.teach("punch", shown(RAISE))
    stage.now += PATIENCE
    state = stage.teaching.state
    assert (state.phase, state.can_keep) == ("failed", True)
    stage.teaching.keep()
    assert stage.teaching.state.phase == "taken"
    assert len(Moves.load(tmp_path / "moves-1.json")) == 3
    with pytest.raises(MossarError, match="nothing to keep"):
        stage.teaching.keep()


def test_the_last_example_is_taken_back(stage, tmp_path):
    assert not stage.teaching.state.can_undo
    with pytest.raises(MossarError, match="no examples"):
        stage.teaching.undo()
    stage.teach("punch", shown(PUNCH))
    state = stage.teach("raise", shown(RAISE))
    assert state.can_undo
    stage.teaching.undo()
    assert Moves.load(tmp_path / "moves-1.json").names == stage.changes[-1].names == ("punch",)
    assert stage.teaching.state.message == "raise: the last example is taken back; 0 left"
    stage.teaching.undo()
    assert not stage.teaching.state.can_undo


def test_a_fixed_length_is_taken_from_the_end_of_the_countdown_on(stage, tmp_path):
    turns = np.concatenate([PUNCH] * 12)
    stage.teaching.begin("punches", MINE, seconds=4.0)
    stage.stream(turns[: round(COUNTED * FPS)])
    assert stage.teaching.state.phase == "count"
    stage.now += COUNTED
    stage.stream(turns[: round(5.0 * FPS)])
    assert stage.teaching.state.phase == "taken", stage.teaching.state.message
    (example,) = Moves.load(tmp_path / "moves-1.json").examples
    positions, rate = example.shown(len(PERSON))
    assert (len(positions) - 1) / rate == pytest.approx(4.0, abs=0.1)


def test_what_cannot_be_taken_is_said_in_one_line(stage, tmp_path):
    holes = shown(PUNCH)
    holes[:, 2] = np.nan
    state = stage.teach("punch", holes)
    assert state.phase == "failed"
    assert "not taken: an example needs all joints" in state.message
    for name in ("", "a\x1b[31m", "x" * 65):
        with pytest.raises(MossarError, match="name"):
            stage.teaching.begin(name, MINE)
    stage.teach("punch", shown(PUNCH))
    with pytest.raises(MossarError, match="another skeleton, with 3 joints; p2 has 2"):
        stage.teaching.begin("wag", Meta("p2", Skeleton(("hip", "tail"), (-1, 0))))
    path = tmp_path / "bad.json"
    path.write_text("{}")
    with pytest.raises(MossarError, match=r"bad\.json"):
        Teaching(tmp_path, path, print)


def test_examples_go_into_the_file_that_was_named_and_are_forgotten_one_by_one(tmp_path):
    path = tmp_path / "mine.json"
    before = Moves(PERSON)
    before.add("raise", RAISE, FPS)
    before.save(path)
    stage = Stage(tmp_path, path)
    assert stage.teaching.moves.names == ("raise",)
    stage.teach("punch", shown(PUNCH))
    assert Moves.load(path).names == ("raise", "punch")
    first, second = (mark_of(example) for example in stage.teaching.moves.examples)
    with pytest.raises(MossarError, match="not there any more"):
        stage.teaching.forget(0, second)
    stage.teaching.forget(0, first)
    assert Moves.load(path).names == stage.changes[-1].names == ("punch",)
    with pytest.raises(MossarError, match="not there any more"):
        stage.teaching.forget(1, second)
    stage.teaching.forget(0, second)
    assert len(Moves.load(path)) == 0


def test_examples_are_drawn_well_formed_and_names_are_quoted(stage):
    stage.teach("a <b> & 'c'", shown(PUNCH))
    card = examples_card(stage.teaching.moves, "<taken>")
    ET.fromstring(card.replace("&times;", "x"))
    assert "<b> &" not in card
    asked = re.search(r"mossar/forget\?'\+\('([^']+)'\)", html.unescape(card))[1]
    assert asked == f"0-{mark_of(stage.teaching.moves.examples[0])}"
    ET.fromstring(countdown(stage.teaching.state))
    many = Moves(PERSON)
    for _ in range(MOST + 5):
        many.add("punch", PUNCH, FPS)
    card = examples_card(many, "")
    assert card.count("<figure") == MOST
    assert "5 earlier ones" in card


def test_nobody_can_show_a_move_before_somebody_is_there(tmp_path):
    with pytest.raises(MossarError, match="no performer yet"):
        LiveShow(Settings(), folder=tmp_path).teach("punch")


def test_a_browser_teaches_a_move_that_is_named_from_then_on_and_survives_kill_9(process, opened, tmp_path):  # noqa: F811
    beats = ",".join(["rest:3", "punch_left"] * 40)
    running = process(
        "view",
        f"demo:?moves={beats}&seed=2",
        "--port",
        "0",
        "--no-browser",
        "--moves",
        "new.json",
        cwd=tmp_path,
    )
    window = opened(address(running)[0])
    window.evaluate(DRAW_NOTHING)
    for count in (1, 2):
        until(window, lambda: window.locator("button:visible:has-text('Teach')").count())
        window.evaluate(WATCH_COUNT)  # the count down may be over before a busy machine looks again
        press(window, "Teach")
        until(window, lambda count=count: f"example {count} taken" in window.text_content("#mossar-taught"))
        until(window, lambda: window.evaluate("window.counted"))  # a slow page may show all of it at once
        assert len(Moves.load(tmp_path / "new.json")) == count
    assert window.locator(".m-example svg path").count() >= 2
    until(window, lambda: "punch" in window.locator("#mossar-chart text.move").all_text_contents())

    window.locator(".m-example button").first.dispatch_event("click")
    until(window, lambda: "forgotten" in window.text_content("#mossar-taught"))
    until(window, lambda: window.locator(".m-example").count() == 1)
    assert len(Moves.load(tmp_path / "new.json")) == 1

    press(window, "Teach")
    until(window, lambda: "example 2 taken" in window.text_content("#mossar-taught"))
    os.kill(running.pid, getattr(signal, "SIGKILL", signal.SIGTERM))
    running.wait(20)
    assert len(Moves.load(tmp_path / "new.json")) == 2
    assert {path.name for path in tmp_path.iterdir() if "json" in path.name} == {"new.json", ".new.json.lock"}
