"""The splitter, one value at a time, against the whole-array oracle."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from checks.reference.algorithms import generate_key_frames
from mossar_stream import Segmenter

SIXTEENTHS = st.lists(st.integers(0, 16), min_size=1, max_size=60)
STEPS = st.lists(st.sampled_from([-4, -2, -1, -1, 0, 0, 0, 1, 1, 2, 4]), min_size=1, max_size=80)
PLATEAUS = st.lists(st.tuples(st.integers(0, 8), st.integers(1, 5)), min_size=1, max_size=16)
CURVES = st.one_of(
    SIXTEENTHS.map(lambda values: [0, *values]),
    STEPS.map(lambda steps: [0, *np.clip(4 + np.cumsum(steps), 0, 16)]),
    PLATEAUS.map(lambda runs: [0, *(2 * value for value, length in runs for _ in range(length))]),
).map(lambda values: np.array(values) / 16)
THETAS = st.sampled_from([0.0, 1 / 64, 1 / 16, 1 / 8, 1 / 4, 1.0])


def of_status(events, status):
    return [
        (e.frame, e.kind) for e in events if e.__struct_config__.tag == "key_frame" and e.status == status
    ]


def accepted(core, curve, theta, sizes=(10**6,)):
    """Return the key frames that were confirmed, less one that was withdrawn when the take ended."""
    events = core.events_in_chunks(
        core.segmenter_of({}, theta), core.hand_steps(curve), np.arange(len(curve)) / core.FPS, sizes
    )
    return sorted(set(of_status(events, "confirmed")) - set(of_status(events, "withdrawn")))


def oracle(curve, theta):
    split = generate_key_frames(curve, theta)
    return list(zip(split.key_frames, split.kinds, strict=True))


@given(CURVES, THETAS)
def test_the_stream_finds_the_oracles_list_on_every_curve(core, curve, theta):
    assert accepted(core, curve, theta) == oracle(curve, theta)


@given(CURVES, THETAS, st.lists(st.integers(1, 9), min_size=1, max_size=4))
def test_chunks_do_not_matter(core, curve, theta, sizes):
    assert accepted(core, curve, theta, sizes) == accepted(core, curve, theta)


@given(CURVES, THETAS, st.data())
def test_a_snapshot_after_any_frame_does_not_matter(core, curve, theta, data):
    cut = data.draw(st.integers(0, len(curve)))
    frames, times = core.hand_steps(curve), np.arange(len(curve)) / core.FPS
    first = core.segmenter_of({}, theta)
    events = first.push(frames[:cut], times[:cut])
    second = Segmenter.restore(first.snapshot())
    events += second.push(frames[cut:], times[cut:]) + second.end_take()
    found = sorted(set(of_status(events, "confirmed")) - set(of_status(events, "withdrawn")))
    assert found == accepted(core, curve, theta)


@given(CURVES, THETAS)
def test_ceiling_and_floor_are_those_of_algorithm_1(core, curve, theta):
    expected = generate_key_frames(curve, theta)
    segmenter = core.segmenter_of({}, theta)
    for t, frame in enumerate(core.hand_steps(curve)):
        segmenter.push(frame, t / core.FPS)
        state = segmenter.state
        assert (state.value, state.ceiling, state.floor) == (curve[t], expected.ceiling[t], expected.floor[t])


@given(CURVES, THETAS)
def test_one_minimum_may_be_confirmed_whose_maximum_never_comes_and_is_withdrawn_at_the_end(
    core, curve, theta
):
    segmenter = core.segmenter_of({}, theta)
    confirmed = sorted(of_status(segmenter.push(core.hand_steps(curve)), "confirmed"))
    taken_back = sorted(set(of_status(segmenter.end_take(), "withdrawn")) & set(confirmed))
    expected = oracle(curve, theta)
    assert sorted(expected + taken_back) == confirmed
    assert len(taken_back) <= 1
    if taken_back:
        assert taken_back[0][1] == "minimum"
        # Its maximum comes with the next lower value.
        lower = curve[-1] - (curve[-1] - theta) / 2
        assert taken_back[0] in oracle(np.append(curve, lower), theta)


def test_the_difference_at_the_end_by_example(core):
    curve = np.array([0, 8, 4, 8]) / 16
    assert oracle(curve, 1 / 16) == accepted(core, curve, 1 / 16) == [(1, "onset")]
    segmenter = core.segmenter_of({}, 1 / 16)
    assert of_status(segmenter.push(core.hand_steps(curve)), "confirmed") == [(1, "onset"), (2, "minimum")]
    assert of_status(segmenter.end_take(), "withdrawn") == [(2, "minimum")]
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
    assert accepted(core, curve, 0.25) == ([(1, "onset")] if level > 0.25 else [])


def test_a_take_begins_with_nothing_of_the_one_before(core):
    frames = core.hand_steps(np.array([0, 8, 4, 6, 3, 9, 5, 7, 2, 8]) / 16)
    begin = [100.0]
    used, fresh = (core.segmenter_of({}, 1 / 16) for _ in range(2))
    used.push(frames, np.arange(len(frames)) / core.FPS)
    used.end_take()
    for segmenter in (used, fresh):
        segmenter.push(frames[:1], begin)
    assert used.row.state["curve"].tobytes() == fresh.row.state["curve"].tobytes()
