"""Rests: two key frames each, but one where the only rest of each counted repetition is a pause between two of them."""

import numpy as np
import pytest

from mossar_stream import Segmenter, Settings, Skeleton

FPS = 30
SKELETON = Skeleton(("hip", "elbow", "hand"), (-1, 0, 1))
COUNTED = 4  # repetitions after which all are counted
TIMES = 10


def performed(*phases):
    """Return (n, 3, 3) m: first a second of rest, then what is repeated, as (duration, position at its end), s."""
    raised, last = [np.zeros(FPS)], 0.0
    for seconds, position in phases * TIMES:
        share = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, round(seconds * FPS), endpoint=False))
        raised.append(last + (position - last) * share)
        last = position
    x = np.concatenate(raised)
    positions = np.zeros((len(x), 3, 3), np.float32)
    positions[:, 1:, 1] = 0.5, 1.0
    positions[:, 1:, 0] = x[:, None] * np.array([0.4, 0.6])
    return positions


def counts_in(core, positions, begins, seconds, **settings):
    """Return how many final key frames lie within 0.2 s of each of the rests that begin then and last so long, s."""
    segmenter = Segmenter(SKELETON, Settings(**settings), fps=FPS)
    events = segmenter.push(positions) + segmenter.end_take()
    times = np.array([event.time for event in core.key_frames(events, "final")])
    return [int(((times > begin - 0.2) & (times < begin + seconds + 0.2)).sum()) for begin in begins]


@pytest.mark.parametrize(("moves", "pauses"), [(0.8, 1.0), (1.0, 1.0), (1.5, 1.0), (1.5, 2.0), (2.0, 1.5)])
def test_the_only_rest_of_counted_repetitions_is_one_key_frame(core, moves, pauses):
    positions = performed((moves, 1.0), (moves, 0.0), (pauses, 0.0))
    ends = 1.0 + 2.0 * moves + (2.0 * moves + pauses) * np.arange(COUNTED, TIMES - 1)
    assert counts_in(core, positions, ends, pauses) == [1] * len(ends)
    assert counts_in(core, positions, ends, pauses, tempo=False) == [2] * len(ends)


def test_of_two_rests_in_each_repetition_both_are_kept(core):
    positions = performed((0.8, 1.0), (1.0, 1.0), (0.8, 0.0), (1.0, 0.0))
    begins = 1.8 + 1.8 * np.arange(2 * COUNTED, 2 * TIMES - 1)
    assert counts_in(core, positions, begins, 1.0) == [2] * len(begins)
