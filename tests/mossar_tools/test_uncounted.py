"""Uncounted: a repeated movement near a followed move that is not counted is logged once; --explain logs each of them."""

import logging

import pytest

from mossar_stream import FollowEvent
from mossar_stream.events import LEFT_REASONS
from mossar_tools.uncounted import WHY, UncountedMoves, line_of_left


def ended(status="left", reason="once", performer="p1", name="squat"):
    return FollowEvent(
        performer=performer, id=f"{performer}/follow/0/1", rev=2, name=name, status=status, take=0, count=0, start=1.0,
        time=2.5, progress=0.9, tempo=1.0, certainty=0.0, deviation=12.4, limbs={}, joint="", range=None, score=None,
        decided_time=2.6, reason="" if status == "done" else reason,
    )  # fmt: skip


@pytest.fixture
def heard(caplog):
    caplog.set_level(logging.INFO)

    def lines(*events, explains=False):
        view = UncountedMoves(explains=explains)
        for event in events:
            view.send([event])
        view.close()
        return [record.getMessage() for record in caplog.records]

    return lines


def test_each_reason_has_words():
    assert set(WHY) == set(LEFT_REASONS) - {""}


def test_one_line_for_each_performer_and_move(heard):
    lines = heard(*[ended()] * 5, *[ended(performer="p2", reason="movement")] * 3)
    assert len(lines) == 2
    assert lines[0].startswith("p1 repeats a movement near 'squat' that is not counted: ")
    assert lines[1].startswith("p2 repeats")
    assert WHY["movement"] in lines[1]


def test_what_is_done_in_between_or_never_ends_is_no_repetition(heard):
    assert heard(ended(), ended(status="done"), ended()) == []
    assert heard(*[ended(reason="unfinished")] * 5, *[ended(reason="gap")] * 5) == []


def test_explaining_has_a_line_for_each_performance_that_was_left(heard):
    lines = heard(ended(reason="unfinished"), ended(status="done"), ended(reason="hidden"), explains=True)
    assert lines == [line_of_left(ended(reason=reason)) for reason in ("unfinished", "hidden")]
    assert (
        lines[0]
        == "p1, 1.00 to 2.50 s: squat not done at a progress of 0.90, deviation 12°: it did not come to the end of the example"
    )


def test_other_events_are_left_alone(heard):
    view = UncountedMoves()
    assert view.dropped == 0
    view.announce(None)
    assert heard() == []
