"""The splitter, one value at a time, against the whole-array oracle."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mossar_stream import Segmenter
from mossar_stream.reference import generate_key_frames

SIXTEENTHS = st.lists(st.integers(0, 16), min_size=1, max_size=60)
STEPS = st.lists(st.sampled_from([-4, -2, -1, -1, 0, 0, 0, 1, 1, 2, 4]), min_size=1, max_size=80)
PLATEAUS = st.lists(st.tuples(st.integers(0, 8), st.integers(1, 5)), min_size=1, max_size=16)
CURVES = st.one_of(
    SIXTEENTHS.map(lambda values: [0, *values]),
    STEPS.map(lambda steps: [0, *np.clip(4 + np.cumsum(steps), 0, 16)]),
    PLATEAUS.map(lambda runs: [0, *(2 * value for value, length in runs for _ in range(length))]),
).map(lambda values: np.array(values) / 16)
THETAS = st.sampled_from([0.0, 1 / 64, 1 / 16, 1 / 8, 1 / 4, 1.0])


def confirmed(core, curve, theta, sizes=(10**6,)):
    events = core.events_in_chunks(
        core.segmenter_of({}, theta), core.hand_steps(curve), np.arange(len(curve)) / core.FPS, sizes
    )
    return sorted((e.frame, e.kind) for e in core.key_frames(events, "confirmed"))


def oracle(curve, theta):
    split = generate_key_frames(curve, theta)
    return list(zip(split.key_frames, split.kinds, strict=True))


def assert_equal_but_for_the_end(found, curve, theta):
    """The list is the oracle's, except for one minimum whose maximum would come with the next lower value."""
    expected = oracle(curve, theta)
    if found == expected:
        return
    last = curve[-1] - (curve[-1] - theta) / 2
    assert last > theta
    longer = [key for key in oracle(np.append(curve, last), theta) if key[0] < len(curve)]
    assert found == longer
    assert [key for key in found if key in expected] == expected
    assert len(found) == len(expected) + 1
    assert next(key for key in found if key not in expected)[1] == "minimum"


@given(CURVES, THETAS)
def test_the_stream_finds_the_oracles_list_on_every_curve(core, curve, theta):
    assert_equal_but_for_the_end(confirmed(core, curve, theta), curve, theta)


@given(CURVES, THETAS, st.lists(st.integers(1, 9), min_size=1, max_size=4))
def test_chunks_do_not_matter(core, curve, theta, sizes):
    assert confirmed(core, curve, theta, sizes) == confirmed(core, curve, theta)


@given(CURVES, THETAS, st.data())
def test_a_snapshot_after_any_frame_does_not_matter(core, curve, theta, data):
    cut = data.draw(st.integers(0, len(curve)))
    frames, times = core.hand_steps(curve), np.arange(len(curve)) / core.FPS
    first = core.segmenter_of({}, theta)
    events = first.push(frames[:cut], times[:cut])
    second = Segmenter.restore(first.snapshot())
    events += second.push(frames[cut:], times[cut:]) + second.end_take()
    found = sorted((e.frame, e.kind) for e in core.key_frames(events, "confirmed"))
    assert found == confirmed(core, curve, theta)


@given(CURVES, THETAS)
def test_ceiling_and_floor_are_those_of_algorithm_1(core, curve, theta):
    expected = generate_key_frames(curve, theta)
    segmenter = core.segmenter_of({}, theta)
    for t, frame in enumerate(core.hand_steps(curve)):
        segmenter.push(frame, t / core.FPS)
        state = segmenter.state
        assert (state.value, state.ceiling, state.floor) == (curve[t], expected.ceiling[t], expected.floor[t])


def test_a_minimum_at_the_end_may_be_confirmed_without_its_maximum(core):
    curve = np.array([0, 8, 4, 8]) / 16
    assert oracle(curve, 1 / 16) == [(1, "onset")]
    assert confirmed(core, curve, 1 / 16) == [(1, "onset"), (2, "minimum")]
    assert oracle(np.append(curve, 0.25), 1 / 16) == [(1, "onset"), (2, "minimum")]


def test_a_key_frame_is_confirmed_when_the_curve_is_back_at_the_ceiling_not_at_the_maximum(core):
    curve = np.array([0, 8, 4, 5, 6, 7, 8, 9, 10, 9]) / 16
    events = core.segmenter_of({}, 1 / 16).push(core.hand_steps(curve))
    (minimum,) = (e for e in core.key_frames(events, "confirmed") if e.kind == "minimum")
    assert (minimum.frame, minimum.decided_frame) == (2, 3)


def test_a_candidate_is_known_at_the_first_different_value(core):
    curve = np.array([0, 8, 4, 4, 4, 4.5, 4, 8]) / 16
    events = core.segmenter_of({}, 1 / 16).push(core.hand_steps(curve))
    candidate = core.key_frames(events, "candidate")[0]
    assert (candidate.frame, candidate.decided_frame, candidate.rev) == (2, 5, 1)
    assert not candidate.decided


@pytest.mark.parametrize("level", [0.0, 0.25, 0.3])
def test_a_constant_curve_has_no_key_frame_but_the_onset(core, level):
    curve = np.array([0.0] + [level] * 40)
    assert confirmed(core, curve, 0.25) == ([(1, "onset")] if level > 0.25 else [])
