"""The likelihood against whole arrays, and its summaries."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mossar_stream.core.kernels import (
    DURATION,
    FRAMES,
    PAGE,
    PAGE_SIZE,
    PATH,
    POSE_X,
    STEP_BEFORE,
    TERM,
    pad,
    similarity_add_frame,
    similarity_close,
    similarity_flush_sums,
    similarity_merge_into,
)
from mossar_stream.core.kernels import similarity_strength as merge_cost
from mossar_stream.settings import Features, Settings
from mossar_stream.similarity.protocol import make_params, slot_size

FEATURES = [
    {"positions": 1.0},
    {"distances": 1.0},
    {"log_speed": 1.0},
    {"positions": 0.75, "log_speed": 0.25},
    {"positions": 0.2, "distances": 0.3, "log_speed": 0.5},
]


def summarise(params, slot, poses, steps, joints, weights):
    body = np.zeros(-(-joints // PAGE) * PAGE_SIZE, np.float32)
    pages = body.reshape(-1, PAGE_SIZE)
    for pose, step, weight in zip(poses, steps, weights, strict=True):
        for first in range(0, joints, PAGE):
            part = slice(first, min(first + PAGE, joints))
            for axis in range(4):
                set_line(pages[first // PAGE], POSE_X + axis * PAGE, pose[axis, part])
            set_line(pages[first // PAGE], STEP_BEFORE, step[part])
        similarity_add_frame(params, slot, body, pose, joints, 0.0, weight, 1, 0.0)
    similarity_flush_sums(params, slot, body, poses.shape[2])
    similarity_close(params, slot)


def set_line(page, line, values):
    page[line : line + len(values)] = values


def merge(params, target, other):
    similarity_merge_into(params, target, other)
    similarity_close(params, target)


class Segment:
    """Frames at random, and their summary."""

    def __init__(self, seed, frames, joints, features, short=0.0):
        rng = np.random.default_rng(seed)
        padded_joints = pad(joints)
        self.settings = Settings(
            level="posture", similarity="likelihood", features=Features(**features), short_segment=short
        ).resolved()
        self.params = make_params(self.settings, joints, padded_joints, 0)
        self.slot = slot_size(self.settings, self.params)
        self.joints, self.poses = joints, np.zeros((frames, 4, padded_joints), np.float32)
        self.poses[:, :, :joints] = rng.normal(rng.normal(0, 1, (1, 4, joints)), 0.1, (frames, 4, joints))
        self.poses[:, :3, 0] = 0  # the root
        self.poses[:, 3, 0] = np.log(0.1)
        self.steps = rng.uniform(0, 0.1, (frames, padded_joints))
        self.weights = rng.uniform(0.01, 0.1, frames)

    def summary(self, begin=0, end=None):
        part = slice(begin, end)
        slot = np.zeros(self.slot)
        summarise(self.params, slot, self.poses[part], self.steps[part], self.joints, self.weights[part])
        return slot

    def groups(self):
        """Return values (n, D), weight per dimension and floor of every feature group."""
        s, others = self.settings, np.arange(1, self.joints)
        p = self.poses[:, :3, : self.joints].transpose(0, 2, 1)
        own = self.params["likelihood"][0]
        count, stride = int(own["offsets"]), int(own["stride"])
        pairs = [(i, (i + 1 + k * stride) % self.joints) for k in range(count) for i in range(self.joints)]
        a, b = np.array(pairs or [(0, 0)]).T
        distances = np.linalg.norm(p[:, a] - p[:, b], axis=2)
        yield p[:, others].reshape(len(p), -1), s.features.positions, s.variance_floor.positions
        yield distances, s.features.distances, s.variance_floor.distances
        yield self.poses[:, 3, others], s.features.log_speed, s.variance_floor.log_speed

    def cost(self, middle):
        """Return the cost of merging the frames before the middle with those from it on, by its definition."""
        total = 0.0
        for values, weight, floor in self.groups():
            terms = []
            for part in (slice(None), slice(0, middle), slice(middle, None)):
                w = self.weights[part]
                mean = np.average(values[part].astype(float), axis=0, weights=w)
                variance = np.average((values[part].astype(float) - mean) ** 2, axis=0, weights=w)
                terms.append(w.sum() * np.log(variance + floor).mean())
            total += weight * (terms[0] - terms[1] - terms[2])
        return max(total, 0.0)


@pytest.mark.parametrize("features", FEATURES)
@given(st.integers(0, 10**6), st.integers(2, 12), st.integers(2, 40), st.data())
def test_the_cost_of_a_merge_is_that_of_the_definition(features, seed, joints, frames, data):
    middle = data.draw(st.integers(1, frames - 1))
    segment = Segment(seed, frames, joints, features)
    both = np.zeros(segment.slot)
    found = merge_cost(segment.params, segment.summary(0, middle), segment.summary(middle), both)
    assert found == pytest.approx(segment.cost(middle), abs=1e-4, rel=1e-4)
    assert found >= 0


@pytest.mark.parametrize("features", FEATURES)
@given(st.integers(0, 10**6), st.integers(1, 20), st.integers(2, 40), st.data())
def test_merged_summaries_are_the_summary_of_the_merged_segment(features, seed, joints, frames, data):
    cuts = sorted(data.draw(st.lists(st.integers(0, frames), max_size=4)))
    segment = Segment(seed, frames, joints, features)
    bounds = [0, *cuts, frames]
    merged = segment.summary(bounds[0], bounds[1])
    for begin, end in itertools.pairwise(bounds[1:]):
        merge(segment.params, merged, segment.summary(begin, end))
    whole = segment.summary()
    np.testing.assert_allclose(merged, whole, rtol=1e-5, atol=1e-5)
    assert merged[FRAMES] == frames
    assert merged[DURATION] == pytest.approx(segment.weights.sum())
    np.testing.assert_allclose(merged[PATH : PATH + joints], segment.steps[:, :joints].sum(axis=0), 1e-5)


def test_merging_costs_nothing_where_nothing_differs():
    segment = Segment(0, 20, 5, {"positions": 0.5, "distances": 0.2, "log_speed": 0.3})
    half = segment.summary()
    both = np.zeros_like(half)
    assert merge_cost(segment.params, half, half.copy(), both) == pytest.approx(0, abs=1e-12)


def test_a_side_shorter_than_short_segment_weighs_less():
    plain, short = (Segment(1, 20, 5, {"positions": 1.0}, short) for short in (0.0, 10.0))
    costs = [merge_cost(s.params, s.summary(0, 8), s.summary(8), s.summary()) for s in (plain, short)]
    shares = plain.weights[:8].sum() / 10, plain.weights[8:].sum() / 10
    assert costs[1] == pytest.approx(costs[0] * shares[0] * shares[1])


def test_a_segment_that_lasts_no_time_says_nothing():
    segment = Segment(2, 10, 4, {"positions": 1.0})
    nothing = np.zeros(segment.slot)
    assert merge_cost(segment.params, nothing, segment.summary(), nothing.copy()) == 0
    segment.weights[:] = 0
    assert segment.summary()[TERM] == 0


@pytest.mark.parametrize("joints", [1, 2, 3])
def test_few_joints_and_duplicate_joints_give_finite_costs(joints):
    segment = Segment(3, 12, joints, {"positions": 0.2, "distances": 0.3, "log_speed": 0.5})
    segment.poses[:, :, :joints] = segment.poses[:, :, :1]
    cost = merge_cost(segment.params, segment.summary(0, 5), segment.summary(5), segment.summary())
    assert np.isfinite(cost)
    assert cost >= 0
