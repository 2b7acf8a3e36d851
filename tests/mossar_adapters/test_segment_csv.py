"""The table of a stream: segments, moves and repetitions, each once and as it is for good."""

import csv

import msgspec
import pytest

from mossar_adapters.address import parse_url
from mossar_adapters.segment_csv import OF_STREAMS, SETTLED, SegmentCsvSink
from mossar_stream import FollowEvent, MoveEvent, RepetitionEvent, StreamEvent


@pytest.fixture
def table(tmp_path):
    """Return a sink, and what reads its rows."""
    path = tmp_path / "x.csv"
    sink = SegmentCsvSink(parse_url(str(path)))

    def rows():
        return list(csv.DictReader(path.read_text().splitlines())) if path.exists() else []

    yield sink, rows
    sink.close()


@pytest.fixture
def repetition(made):
    """Return what makes the repetition of a number, 2 s each; one that is withdrawn says nothing of its cycle."""

    def make(number, *, take=0, **fields):
        own = {"id": f"p1/{take}/r{number}", "take": take, "decided_time": 2.0 * number + 3.0}
        if fields.get("status") == "withdrawn":
            nothing = dict.fromkeys(("period", "tempo", "start", "end", "amplitude", "joint"))
            return made(RepetitionEvent, count=0, total=number - 1, **own, **nothing, **fields)
        own |= {"count": number, "total": number, "start": 2.0 * number, "end": 2.0 * number + 2.0}
        return made(RepetitionEvent, **{**own, **fields})

    return make


def test_a_repetition_has_a_row_with_what_was_said_of_it_last(table, repetition):
    sink, rows = table
    sink.send([repetition(1), repetition(2), repetition(3)])
    sink.send([repetition(2, rev=2, end=5.5), repetition(3, rev=2, status="withdrawn")])
    assert rows() == []  # a later look may change them again
    sink.close()
    found = rows()
    assert tuple(found[0]) == OF_STREAMS
    assert [(row["state"], row["count"], row["total"]) for row in found] == [
        ("repetition", "1", "1"),
        ("repetition", "2", "2"),
    ]
    assert (found[1]["start"], found[1]["end"], found[1]["duration"]) == ("4.0000", "5.5000", "1.5000")
    assert (found[1]["tempo"], found[1]["active_joints"], found[1]["channel"]) == ("30.0000", "hand", "body")
    assert found[1]["start_frame"] == ""


def test_repetitions_that_nothing_changes_any_more_are_written(table, repetition):
    sink, rows = table
    sink.send([repetition(number) for number in range(1, SETTLED + 4)])
    assert [row["count"] for row in rows()] == ["1", "2", "3"]
    sink.begin_take("p2", 1, 0.0)  # of another performer
    assert len(rows()) == 3
    sink.begin_take("p1", 1, 0.0)
    assert [int(row["count"]) for row in rows()] == list(range(1, SETTLED + 4))
    sink.send([repetition(1, take=1)])
    gone = StreamEvent(performer="p1", event="ended", take=1, reason="gone")
    sink.send([gone])
    assert (rows()[-1]["take"], rows()[-1]["count"]) == ("1", "1")


def test_a_move_has_a_row_once_it_is_final(table):
    sink, rows = table
    move = MoveEvent(
        performer="p1",
        id="p1/move/0/1",
        rev=1,
        name="=punch",
        status="confirmed",
        take=0,
        start=1.0,
        end=1.5,
        score=0.8,
        limb="left_arm",
        decided_time=1.6,
    )
    sink.send([move])
    assert rows() == []
    sink.send([msgspec.structs.replace(move, rev=2, status="final", end=1.6)])
    (row,) = rows()
    assert (row["state"], row["name"], row["limb"], row["score"]) == ("move", "'=punch", "left_arm", "0.8000")
    assert (row["start"], row["end"]) == ("1.0000", "1.6000")


def test_a_performance_of_a_followed_move_has_a_row_when_it_is_done(table, made):
    sink, rows = table
    done = {"status": "done", "count": 3, "progress": 1.0, "range": {"left_leg": 0.5}, "score": 0.25}
    sink.send([made(FollowEvent), made(FollowEvent, **done), made(FollowEvent, status="left", count=3)])
    [row] = rows()
    assert (row["state"], row["name"], row["count"], row["limb"]) == ("followed", "squat", "3", "left_leg")
    assert (row["start"], row["end"], row["score"]) == ("12.0000", "13.0000", "0.2500")
    assert (row["relative_tempo"], row["tempo"], row["deviation"]) == ("1.2500", "", "8.0000")
    assert (row["deviation_left_leg"], row["deviation_left_arm"]) == ("12.0000", "")
    assert (row["range_left_leg"], row["range_trunk"]) == ("0.5000", "")
