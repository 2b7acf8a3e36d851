"""Following from the command line: what was shown once is counted and judged, live and in whole recordings."""

import csv
import io
import json
import xml.etree.ElementTree as ET

import pytest

from mossar_adapters.annotations.reading import read_annotations
from mossar_adapters.pipeline.emission import Emission
from mossar_stream import FollowEvent, MoveEvent
from mossar_tools.console import Console
from mossar_tools.live_view import LiveView

TAKE = "demo:?seed=2&moves=rest:2,squat,squat,squat,squat,rest:2"  # each squat of the performer is made twice
ONE = ("--from", "3.4", "--until", "4.6")
LIMBS = {"trunk", "left_arm", "right_arm", "left_leg", "right_leg"}


@pytest.fixture(scope="module")
def moves(tmp_path_factory):
    """A file with one squat out of the middle of the take, and a punch."""
    from mossar_tools.cli import main

    path = tmp_path_factory.mktemp("moves") / "moves.json"
    assert main(["teach", str(path), TAKE, "--name", "squat", *ONE]) == 0
    shown = ["demo:?tempo=0.6&moves=rest:1,punch_left", "--from", "1.45", "--until", "2.18"]
    assert main(["teach", str(path), *shown, "--name", "punch"]) == 0
    return path


def test_every_squat_of_a_stream_is_counted_and_judged_while_it_is_made(events, moves):
    found = events("run", TAKE, "--speed", "max", "--moves", moves, "--follow", "squat", "--emit", "follow")
    assert {event["type"] for event in found} == {"follow"}
    assert {event["name"] for event in found} == {"squat"}
    done = [event for event in found if event["status"] == "done"]
    assert [event["count"] for event in done] == list(range(1, len(done) + 1))
    assert len(done) == 8
    assert all(set(event["limbs"]) == LIMBS and event["score"] > 0.9 for event in done)
    progress = [event for event in found if event["status"] == "progress"]
    assert all(0.0 <= event["progress"] <= 1.0 and event["score"] is None for event in progress)
    assert len(progress) > 2 * len(done)


def test_all_follows_every_move_and_one_does_not(mossar, moves):
    status, out, _ = mossar("segment", TAKE, "--moves", moves, "--follow", "all", "--json")
    followed = json.loads(out)["followed"]
    assert (status, {event["name"] for event in followed}) == (0, {"squat"})  # nobody punches
    out = mossar("segment", TAKE, "--moves", moves, "--json")[1]
    assert "followed" not in json.loads(out)


def test_a_recording_has_a_line_and_a_row_for_each_performance(mossar, moves):
    status, out, _ = mossar("segment", TAKE, "--moves", moves, "--follow", "squat")
    lines = out.splitlines()
    assert (status, "squat: 8 done" in lines) == (0, True)
    assert sum("tempo" in line and "deviation" in line for line in lines) == 8
    assert not any(line.startswith("squat, ") for line in lines)  # the recognised ones are the same squats
    out = mossar("segment", TAKE, "--moves", moves, "--follow", "squat", "--csv")[1]
    rows = [row for row in csv.DictReader(io.StringIO(out)) if row["state"] == "followed"]
    assert [(row["name"], row["count"]) for row in rows] == [("squat", str(n)) for n in range(1, 9)]
    assert all(float(row[f"deviation_{limb}"]) < 10 for row in rows for limb in LIMBS)
    assert 0.5 < float(rows[1]["range_left_leg"]) < 1.5
    assert rows[1]["limb"] in LIMBS


@pytest.mark.parametrize(
    ("more", "says"),
    [
        (
            ("--moves", "{moves}", "--follow", "squatt"),
            "--follow squatt: {moves} has no such move; there are squat, punch",
        ),
        (("--follow", "squat"), "--follow needs --moves FILE"),
        (("--moves", "{moves}", "--follow"), "argument --follow: expected one argument"),
        (("--moves", "{moves}", "--follow", ","), "there is no name in it"),
    ],
)
@pytest.mark.parametrize("command", ["run", "segment", "archive"])
def test_what_cannot_be_followed_is_refused_in_one_line(mossar, moves, tmp_path, command, more, says):
    place = (tmp_path, tmp_path / "tables") if command == "archive" else (TAKE,)
    status, out, err = mossar(command, *place, *(word.format(moves=moves) for word in more))
    assert (status, out) == (2, "")
    assert says.format(moves=moves) in err
    assert len(err.splitlines()) == 1


def test_a_configuration_names_what_to_follow(events, moves, tmp_path):
    file = tmp_path / "c.toml"
    file.write_text(f'moves = "{moves}"\nfollow = ["punch", "squat"]\nemit = ["follow.done"]\n')
    assert len(events("run", TAKE, "--speed", "max", "--config", file)) == 8
    file.write_text(f'moves = "{moves}"\nfollow = "all"\nemit = ["follow.done"]\n')
    assert len(events("run", TAKE, "--speed", "max", "--config", file)) == 8


def test_a_terminal_shows_each_performance_that_is_done_and_how_far_the_next_one_is(made):
    out = io.StringIO()
    view = LiveView(Console(out, io.StringIO()), [], visible=True, emission=Emission())
    done = {"status": "done", "count": 3, "progress": 1.0, "score": 0.6}
    view.send([made(FollowEvent), made(FollowEvent, **done)])
    assert (
        " ".join(out.getvalue().split())
        == "p1 13.00 s squat 3, tempo 1.25, deviation 8 deg (left leg 12 deg)"
    )
    assert "squat, p1: 3 done in the last take" in view.summary()


def test_recognised_moves_are_not_counted_beside_those_that_are_followed(made):
    view = LiveView(Console(io.StringIO(), io.StringIO()), [], visible=False)
    view.send([made(FollowEvent, status="done", count=3)])
    for name in ("squat", "jab", "jab"):
        view.send([made(MoveEvent, name=name)])
    counts = [line for line in view.summary() if ", p1: " in line]
    assert counts == ["squat, p1: 3 done in the last take", "jab, p1: recognised 2 times"]


def test_a_picture_has_a_panel_for_each_limb_and_a_bar_for_each_performance(mossar, moves, tmp_path):
    pytest.importorskip("matplotlib")
    path = tmp_path / "followed.svg"
    given = ("--moves", moves, "--follow", "all", "--plot", path)
    assert mossar("segment", TAKE, *given)[0] == 0
    texts = ["".join(e.itertext()) for e in ET.parse(path).getroot().iter("{http://www.w3.org/2000/svg}text")]
    assert {"body", *(limb.replace("_", " ") for limb in LIMBS)} <= set(texts)
    assert any(text.startswith("8 performances; coloured") for text in texts)
    assert path.read_text().count("#94b8d3") + path.read_text().count("#d55e00") >= 8 * 6
    # Nothing was done: the usual picture.
    assert mossar("segment", "demo:?moves=rest:3", *given, "--force")[0] == 0
    assert "strength" in path.read_text()


def test_annotations_have_a_tier_for_each_followed_move(mossar, moves, tmp_path):
    for path in (tmp_path / "a.vtt", tmp_path / "a.tsv"):
        assert mossar("segment", TAKE, "--moves", moves, "--follow", "all", "--export", path)[0] == 0
        assert "punch" not in path.read_text()
        [tier] = [tier for tier in read_annotations(path) if tier.name == "followed squat"]
        assert [mark.label for mark in tier.marks] == [str(n) for n in range(1, 9)]
    table = tmp_path / "a.csv"
    assert mossar("segment", TAKE, "--moves", moves, "--follow", "all", "--csv", table)[0] == 0
    assert len(next(tier for tier in read_annotations(table) if tier.name == "followed squat").marks) == 8


def test_clips_are_cut_of_each_performance(mossar, moves, tmp_path):
    given = ("--moves", moves, "--follow", "squat", "--of", "followed", "--cut", tmp_path / "clips")
    assert mossar("segment", TAKE, *given)[0] == 0
    assert len([path for path in (tmp_path / "clips").iterdir() if "squat_" in path.name]) == 8


def test_run_explains_each_performance_that_was_given_up_and_changes_no_event(mossar, moves):
    take = "demo:?seed=4&moves=rest:1,squat,turn,jump,squat,rest:1"
    given = ("run", take, "--speed", "max", "--moves", moves, "--follow", "squat", "--emit", "follow")
    plain, explained = mossar(*given), mossar(*given, "--explain")
    assert explained[1] == plain[1]
    left = [event for event in map(json.loads, plain[1].splitlines()) if event["status"] == "left"]
    lines = [line for line in explained[2].splitlines() if "squat not done at a progress of" in line]
    assert len(lines) == len(left) > 0
    assert all(event["reason"] == "unfinished" for event in left)
    assert "not done" not in plain[2]
