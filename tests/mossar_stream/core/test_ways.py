"""Ways: out of the first pose and back through the same poses, which is a repetition before any is counted."""

import itertools

import numpy as np
import pytest

from mossar_stream import KeyFrameEvent, Segmenter, Settings, Skeleton

FPS = 30
SKELETON = Skeleton(("hip", "elbow", "hand"), (-1, 0, 1))
REST = 1.0  # s, before a movement and after it, unless said


def shown(*goals, seconds=3.0, rest=REST):
    """Return (n, 3, 3) m of an arm that rests, goes to each place of the hand, (x, y) m, in so many seconds, and rests."""
    places = np.array([(0.0, 0.0), *goals])
    share = 0.5 - 0.5 * np.cos(np.pi * np.arange(round(seconds * FPS)) / round(seconds * FPS))
    parts = [a + share[:, None] * (b - a) for a, b in itertools.pairwise(places)]
    before, after = (np.repeat(place, round(rest * FPS), axis=0) for place in (places[:1], places[-1:]))
    hand = np.concatenate([before, *parts, after])
    positions = np.zeros((len(hand), 3, 3), np.float32)
    positions[:, 1:, 1] = 0.5, 1.0
    positions[:, 2, :2] += hand
    positions[:, 1, :2] += 0.5 * hand
    return positions


def way_of(positions):
    """Return when the latest way began and ended, s."""
    segmenter = Segmenter(SKELETON, fps=FPS)
    segmenter.push(positions)
    ways = segmenter.row.state["ways"]
    return float(ways["begins"]), float(ways["ends"])


def finals(positions):
    """Return the times of the final key frames, s."""
    segmenter = Segmenter(SKELETON, fps=FPS)
    events = [*segmenter.push(positions), *segmenter.end_take()]
    return [event.time for event in events if isinstance(event, KeyFrameEvent) and event.status == "final"]


@pytest.mark.parametrize("seconds", [1.0, 3.0, 6.0])
def test_a_way_ends_as_the_performer_comes_home_the_way_they_went(seconds):
    begins, ends = way_of(shown((0.6, 0.0), (0.0, 0.0), seconds=seconds))
    assert REST <= begins <= REST + 0.4 * seconds
    assert REST + 1.5 * seconds <= ends <= REST + 2.0 * seconds


@pytest.mark.parametrize(
    "goals",
    [
        [(0.6, 0.0)],  # out only
        [(0.4, 0.4), (0.8, 0.0), (0.4, -0.4), (0.0, 0.0)],  # back another way
        [(0.6, 0.0), (0.25, 0.0), (0.6, 0.0), (0.25, 0.0), (0.6, 0.0), (0.0, 0.0)],  # out three times
    ],
)
def test_other_ways_are_none(goals):
    assert way_of(shown(*goals)) == (np.inf, np.inf)


def test_the_latest_way_is_known():
    _, first = way_of(shown((0.6, 0.0), (0.0, 0.0)))
    begins, ends = way_of(shown((0.6, 0.0), (0.0, 0.0), (0.0, 0.6), (0.0, 0.0)))
    assert first <= begins <= first + 3.0
    assert begins + 4.0 <= ends <= REST + 12.0


def test_nobody_follows_ways_once_something_is_counted():
    segmenter = Segmenter(SKELETON, Settings(repetitions=True), fps=FPS)
    positions, looked_at = shown(*[(0.6, 0.0), (0.0, 0.0)] * 6, seconds=1.5), []
    for i, frame in enumerate(positions):
        segmenter.push(frame, i / FPS)
        if segmenter.repetitions > 0:
            looked_at.append(int(segmenter.row.state["ways"]["samples"]))
    assert segmenter.repetitions == 6
    assert looked_at == [looked_at[0]] * len(looked_at)


@pytest.mark.parametrize("seconds", [1.5, 3.0, 4.0])
def test_who_moves_on_has_no_key_frame_on_the_way_and_one_at_its_end(seconds):
    positions = shown((0.6, 0.0), (0.0, 0.0), (0.6, 0.0), seconds=seconds, rest=0.2)
    begins, ends = way_of(positions)
    found = finals(positions)
    assert not [time for time in found if begins < time < ends]
    assert [time for time in found if time > ends] == pytest.approx([0.2 + 2.0 * seconds], abs=0.1)


def test_who_stops_at_every_turn_has_key_frames_on_the_way():
    positions = shown((0.3, 0.0), (0.6, 0.0), (0.3, 0.0), (0.0, 0.0), seconds=0.7)
    begins, ends = way_of(positions)
    assert len([time for time in finals(positions) if begins < time < ends]) >= 2


def test_the_way_is_the_same_for_every_way_of_chopping():
    positions = shown((0.6, 0.0), (0.0, 0.0))
    segmenter = Segmenter(SKELETON, fps=FPS)
    for i, frame in enumerate(positions):
        segmenter.push(frame, i / FPS)
    ways = segmenter.row.state["ways"]
    assert (float(ways["begins"]), float(ways["ends"])) == pytest.approx(way_of(positions), abs=1e-9)
