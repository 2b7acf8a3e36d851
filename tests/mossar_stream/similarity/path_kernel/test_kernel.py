"""The path kernel against its oracle, from frames to Algorithm 3."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from checks.reference import algorithms as reference
from checks.reference import path_kernel as path_reference
from mossar_stream.core.kernels import (
    DURATION,
    FRAMES,
    MOVING_FRAMES,
    PAGE,
    PAGE_SIZE,
    PATH,
    STEP_BEFORE,
    TERM,
    pad,
    similarity_add_frame,
    similarity_strength,
)
from mossar_stream.core.kernels import similarity_add_pose as add_pose
from mossar_stream.core.kernels import similarity_close as close
from mossar_stream.core.kernels import similarity_merge_into as merge_into
from mossar_stream.core.kernels import similarity_remerge as remerge
from mossar_stream.core.kernels import similarity_similarity as alike
from mossar_stream.errors import SettingsError
from mossar_stream.settings import Settings
from mossar_stream.similarity import protocol

FORMS = ("damped", "normalised", "sum")
STEP = 1.0 / 64.0


def add_frame(params, slot, pose, step, joints, time, weight, moving):
    body = np.zeros(-(-joints // PAGE) * PAGE_SIZE, np.float32)
    each = np.arange(joints)
    body[each // PAGE * PAGE_SIZE + each % PAGE + STEP_BEFORE] = step[:joints]
    similarity_add_frame(params, slot, body, pose, joints, time, weight, moving, 0.0)


def strength(params, left, right):
    return similarity_strength(params, left, right, left)


def make_params(joints, *, form="damped", edges=20, layers=1):
    chosen = Settings(
        similarity="path_kernel", kernel_form=form, edges=edges, layers=layers, location="none"
    ).resolved()
    return protocol.make_params(chosen, joints, pad(joints), 0)


def own(params):
    return params["path_kernel"][0]


def slot_size(params):
    return int(own(params)["size"])


def times_of(positions, start=0.0):
    return start + STEP * np.arange(len(positions))


def summary(params, positions, times, weight=STEP):
    slot = np.zeros(slot_size(params))
    padded_joints = int(own(params)["padded_joints"])
    joints = positions.shape[1]
    pose, step = np.zeros((4, padded_joints), np.float32), np.zeros(padded_joints)
    step[:joints] = 0.01
    for frame, time in zip(positions, times, strict=True):
        pose[:3, :joints] = frame.T
        add_frame(params, slot, pose, step, joints, time, weight, 1)
    return slot


def closed(params, positions, times):
    slot = summary(params, positions, times)
    close(params, slot)
    return slot


def graph_of(params, positions, times):
    weights = np.full(len(positions), STEP)
    positions = positions.astype(np.float32).astype(float)  # as a sensor gives them
    return path_reference.segment_graph(
        positions, times, weights, int(own(params)["edges"]), int(own(params)["layers"])
    )


def stored_graph(params, slot):
    """Return what a closed summary holds, in the oracle's form."""
    p = own(params)
    at = int(p["covariances_at"])
    covariances = slot[at : at + p["joints"] * p["covariance"]].reshape(p["joints"], -1)
    at = int(p["edges_at"])
    count = int(slot[at])
    pairs = slot[at + 1 : at + 1 + count].astype(int)
    values = slot[at + 1 + int(p["edges"]) :][:count]
    edges = {
        (
            int(pair % p["padded_joints"]),
            int((pair % p["padded_joints"] + pair // p["padded_joints"] + 1) % p["joints"]),
        ): value
        for pair, value in zip(pairs, values, strict=True)
    }
    return covariances, edges


def check_graph(params, slot, positions, times):
    covariances, edges = stored_graph(params, slot)
    expected = graph_of(params, positions, times)
    elements = np.tile([1.0, 0.0, 0.0, 1.0, 0.0, 1.0], covariances.shape[1] // 6)
    np.testing.assert_allclose(
        covariances - own(params)["diagonal"] * elements, expected.covariances, rtol=1e-9, atol=1e-12
    )
    assert set(edges) == set(expected.edges)
    for pair, value in edges.items():
        assert value == pytest.approx(expected.edges[pair], abs=3e-9)


def wander(seed, frames, joints, scale=0.03):
    """Return a random walk around a random pose."""
    rng = np.random.default_rng(seed)
    return rng.normal(0.0, 0.4, (joints, 3)) + np.cumsum(rng.normal(0.0, scale, (frames, joints, 3)), axis=0)


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 2**32), st.integers(1, 40), st.integers(1, 14), st.integers(1, 45), st.integers(1, 4))
def test_a_closed_summary_holds_the_graph_of_its_frames(seed, frames, joints, edges, layers):
    params = make_params(joints, edges=edges, layers=layers)
    positions = wander(seed, frames, joints)
    times = times_of(positions, seed / 7.0)
    check_graph(params, closed(params, positions, times), positions, times)


@settings(deadline=None, max_examples=60)
@given(
    st.integers(0, 2**32), st.lists(st.integers(0, 90), min_size=2, max_size=5), st.integers(1, 4), st.data()
)
def test_merged_summaries_are_the_summary_of_the_merged_segment(seed, lengths, layers, data):
    params = make_params(9, layers=layers)
    positions = wander(seed, sum(lengths) + 1, 9)[1:]
    times = times_of(positions, seed / 3.0)
    cuts = np.cumsum(lengths)[:-1]
    parts = [
        summary(params, *part) for part in zip(np.split(positions, cuts), np.split(times, cuts), strict=True)
    ]
    while len(parts) > 1:  # in any order, and either way round
        at = data.draw(st.integers(0, len(parts) - 2))
        keep, gone = data.draw(st.permutations([at, at + 1]))
        merge_into(params, parts[keep], parts[gone])
        del parts[gone]
    whole = summary(params, positions, times)
    close(params, parts[0])
    close(params, whole)
    np.testing.assert_allclose(parts[0], whole, rtol=1e-9, atol=1e-11)
    if len(positions):
        check_graph(params, parts[0], positions, times)


def test_a_long_segment_keeps_its_bins():
    params = make_params(5, layers=3)
    positions = wander(1, 5000, 5)
    times = times_of(positions, 1.7e9)
    check_graph(params, closed(params, positions, times), positions, times)


@pytest.mark.parametrize("form", FORMS)
@settings(deadline=None, max_examples=25)
@given(st.integers(0, 2**32), st.integers(2, 30), st.integers(2, 30), st.integers(2, 8), st.integers(1, 10))
def test_the_kernel_equals_brute_force(form, seed, before, after, joints, edges):
    params = make_params(joints, form=form, edges=edges)
    positions = wander(seed, before + after, joints)
    times = times_of(positions)
    a, b = (
        closed(params, positions[:before], times[:before]),
        closed(params, positions[before:], times[before:]),
    )
    graphs = (
        graph_of(params, positions[:before], times[:before]),
        graph_of(params, positions[before:], times[before:]),
    )
    if form != "sum":
        assert a[TERM] == pytest.approx(path_reference.kernel(graphs[0], graphs[0], form), rel=1e-9)
    assert strength(params, a, b) == pytest.approx(path_reference.strength(*graphs, form), rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("form", FORMS)
@settings(deadline=None, max_examples=25)
@given(st.integers(0, 2**32), st.integers(1, 30), st.integers(1, 30), st.integers(1, 24), st.integers(1, 45))
def test_the_kernel_is_symmetric_and_normalised_to_one(form, seed, before, after, joints, edges):
    params = make_params(joints, form=form, edges=edges, layers=2)
    a = closed(params, wander(seed, before, joints), np.arange(before) * STEP)
    b = closed(params, wander(seed + 1, after, joints), 100.0 + np.arange(after) * STEP)
    there, back, self = strength(params, a, b), strength(params, b, a), strength(params, a, a)
    assert there == pytest.approx(back, rel=1e-12)
    most = {"damped": np.sqrt(before * after * STEP / (before + after)), "normalised": 1.0, "sum": 1.0}[form]
    assert 0.0 <= there <= most
    assert 0.0 <= alike(params, there, a, b) <= 1.0
    if form != "sum":
        assert self == pytest.approx(0.0, abs=1e-12)
        assert alike(params, self, a, a) == pytest.approx(1.0)


def constant(frames, joints):
    return np.repeat(wander(3, 1, joints), frames, axis=0)


def duplicated(frames, joints):
    return np.repeat(wander(3, frames, max(1, joints // 2)), 2, axis=1)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("layers", [1, 3])
@pytest.mark.parametrize(
    ("left", "right"),
    [
        (constant(20, 6), constant(20, 6)),
        (constant(20, 6), wander(1, 20, 6)),
        (wander(1, 20, 1), wander(2, 20, 1)),
        (wander(1, 20, 2), wander(2, 20, 2)),
        (duplicated(20, 6), duplicated(10, 6)),
        (np.zeros((5, 6, 3)), np.zeros((5, 6, 3))),
        (np.zeros((5, 6, 3)), wander(1, 5, 6)),
        (wander(1, 1, 6), wander(1, 20, 6)),
        (wander(1, 1, 6), wander(1, 1, 6)),
        (1e5 * wander(1, 9, 6), 1e-9 * wander(1, 9, 6)),
        (wander(1, 30, 90), wander(2, 30, 90)),
    ],
)
def test_degenerate_segments_are_compared_as_the_oracle_does(form, layers, left, right):
    joints = left.shape[1]
    params = make_params(joints, form=form, edges=45 if joints < 90 else 8, layers=layers)
    times = times_of(left), times_of(right, 50.0)
    found = strength(params, closed(params, left, times[0]), closed(params, right, times[1]))
    expected = path_reference.strength(
        graph_of(params, left, times[0]), graph_of(params, right, times[1]), form
    )
    assert np.isfinite(found)
    assert found == pytest.approx(expected, rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("frames", [0, 1, 5])
def test_a_segment_without_duration_says_nothing(form, frames):
    params = make_params(6, form=form)
    positions = wander(1, 20, 6)
    a = closed(params, positions, times_of(positions))
    b = summary(params, positions[:frames], times_of(positions[:frames]), weight=0.0)
    close(params, b)
    assert strength(params, a, b) == strength(params, b, a) == strength(params, b, b) == 0.0
    assert alike(params, 0.0, a, b) == 1.0
    assert b[FRAMES] == frames
    before = a.copy()
    merge_into(params, a, b)
    a[FRAMES], a[MOVING_FRAMES] = before[FRAMES], before[MOVING_FRAMES]
    a[PATH : PATH + 6] = before[PATH : PATH + 6]
    np.testing.assert_array_equal(a, before)


def test_rounding_noise_of_rigid_pairs_and_coinciding_joints_makes_no_edge():
    rng = np.random.default_rng(0)
    positions = np.repeat(wander(3, 1, 6), 30, axis=0) + rng.normal(0.0, 3e-7, (30, 6, 3))
    positions[:, 5] = positions[:, 4] + rng.normal(0.0, 3e-7, (30, 3))
    params = make_params(6, edges=45)
    assert stored_graph(params, closed(params, positions, times_of(positions)))[1] == {}


def test_pairs_that_tie_are_chosen_in_the_same_order_whatever_the_merges():
    positions = wander(5, 40, 5)
    # Mirrored: every RRJRD twice.
    positions = np.concatenate([positions, positions * [-1.0, 1.0, 1.0]], axis=1)
    params = make_params(10, edges=7)
    times = times_of(positions)
    whole = closed(params, positions, times)
    for cut in range(1, 40, 3):
        a, b = summary(params, positions[:cut], times[:cut]), summary(params, positions[cut:], times[cut:])
        merge_into(params, a, b)
        close(params, a)
        assert stored_graph(params, a)[1].keys() == stored_graph(params, whole)[1].keys()


def test_held_poses_count_by_the_time_they_stand_for():
    params = make_params(4)
    poses = wander(2, 2, 4)
    held, repeated = np.zeros(slot_size(params)), np.zeros(slot_size(params))
    pose = np.zeros((4, 8), np.float32)
    for frame, count in zip(poses, (3, 1), strict=True):
        pose[:3, :4] = frame.T
        add_pose(params, held, pose, 4, 1.0, count * 0.25)
        for _ in range(count):
            add_pose(params, repeated, pose, 4, 1.0, 0.25)
    assert held[DURATION] == repeated[DURATION] == 1.0
    close(params, held)
    close(params, repeated)
    np.testing.assert_allclose(held, repeated, rtol=1e-12, atol=1e-15)


def test_free_location_is_refused():
    chosen = Settings(similarity="path_kernel", location="free").resolved()
    with pytest.raises(SettingsError, match="location=free"):
        protocol.make_params(chosen, 4, 8, 0)


def hierarchy_of(params, positions, times, bounds):
    """Run Algorithm 3 on summaries made frame by frame; return the key frames as they are removed, with their strengths."""
    count = len(bounds) - 2
    segments = np.stack([closed(params, positions[a:b], times[a:b]) for a, b in pairwise(bounds)])
    costs, removed = np.zeros((2, count)), np.zeros(count, np.int64)
    remerge(params, segments, np.arange(count + 2), costs[0], costs[1], removed)
    return [(bounds[1 + k], costs[1, k]) for k in removed]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("layers", [1, 2])
@pytest.mark.parametrize("seed", range(4))
def test_algorithm_3_equals_the_reference(form, layers, seed):
    rng = np.random.default_rng(seed)
    params = make_params(7, form=form, edges=9, layers=layers)
    positions = wander(seed, 240, 7)
    times = times_of(positions, 1e6 / 7.0)
    key_frames = sorted(rng.choice(np.arange(1, 240), 12, replace=False).tolist())

    def cost(a, k, b):
        graphs = graph_of(params, positions[a:k], times[a:k]), graph_of(params, positions[k:b], times[k:b])
        return path_reference.strength(*graphs, form)

    expected = reference.remerge(key_frames, 0, 240, cost)
    found = hierarchy_of(params, positions, times, [0, *key_frames, 240])
    assert [frame for frame, _ in found] == [frame for frame, _ in expected]
    np.testing.assert_allclose([s for _, s in found], [s for _, s in expected], rtol=1e-9, atol=1e-9)
