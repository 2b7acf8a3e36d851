"""What is asked for and cannot come is refused; what an output leaves out is said."""

import csv
import io
import json

import pytest

from mossar_adapters.pipeline.emission import Emission
from mossar_stream import ActivityEvent, RepetitionEvent
from mossar_tools.console import Console
from mossar_tools.live_view import LiveView

RUN = ("run", "demo:?seconds=1", "--speed", "max")


@pytest.mark.parametrize(
    ("emit", "missing"),
    [
        ("move", "--moves"),
        ("move.confirmed,stream", "--moves"),
        ("repetition", "--repetitions"),
        ("phase", "--set repetitions=true --set phase=true"),
        ("stats", "--stats"),
    ],
)
def test_events_that_cannot_come_are_refused(mossar, emit, missing):
    status, out, err = mossar(*RUN, "--emit", emit)
    assert (status, out) == (2, "")
    assert f"there are none without {missing}" in err
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize(
    "more",
    [("--emit", "repetition", "--repetitions"), ("--emit", "stats", "--stats", "1"), ("--emit", "final")],
)
def test_events_that_can_come_are_not(mossar, more):
    assert mossar(*RUN, *more)[0] == 0


def test_a_table_says_what_it_has_no_place_for(mossar, tmp_path):
    table = tmp_path / "x.csv"
    assert "no rows for steps; they go to" in mossar(*RUN, "--to", table, "--steps")[2]
    assert "no rows for" not in mossar(*RUN, "--to", table, "--repetitions", "--force")[2]


def shown(*events, emit=()):
    out = io.StringIO()
    view = LiveView(Console(out, io.StringIO()), [], visible=True, emission=Emission(emit))
    view.send(events)
    return out.getvalue().splitlines(), view.summary()


@pytest.fixture
def repetition(made):
    return lambda total, status="counted": made(
        RepetitionEvent, id=f"p1/0/r{total}", status=status, count=total, total=total
    )


def test_a_terminal_shows_how_often(repetition):
    lines, summary = shown(repetition(1), repetition(2))
    assert [" 1 repetition (1 in a row" in lines[0], " 2 repetitions (2 in a row" in lines[1]] == [
        True,
        True,
    ]
    assert "30 a minute" in lines[1]
    assert "repetitions of p1 in the last take: 2" in summary


def test_a_terminal_shows_only_what_is_asked_for(repetition):
    moved = {"performer": "p1", "id": "p1/activity/0/1", "take": 0, "start": 1.0, "decided_time": 1.1}
    activity = ActivityEvent(**moved, state="moving", previous=None, limb=None)
    lines, _ = shown(activity, repetition(1), emit=("activity",))
    assert len(lines) == 1
    assert "moving" in lines[0]


def test_a_table_of_a_run_has_the_repetitions_that_events_report(mossar, tmp_path):
    source = "demo:?seed=3&moves=rest,squat,squat,squat,squat,squat,rest&tempo=1"
    table, lines = tmp_path / "x.csv", tmp_path / "x.jsonl"
    run = ("run", f"{source}&seconds=20", "--speed", "max", "--repetitions", "--to", table, "--to", lines)
    status, _, err = mossar(*run)
    assert (status, "no rows" in err) == (0, False)
    rows = [row for row in csv.DictReader(table.read_text().splitlines()) if row["state"] == "repetition"]
    events = map(json.loads, lines.read_text().splitlines())
    latest = {event["id"]: event for event in events if event["type"] == "repetition"}
    counted = [event for event in latest.values() if event["status"] == "counted"]
    assert len(counted) >= 3
    assert [(row["count"], row["start"]) for row in rows] == [
        (str(event["count"]), f"{event['start']:.4f}") for event in counted
    ]
