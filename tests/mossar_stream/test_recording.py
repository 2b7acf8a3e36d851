"""Whole recordings: against an independent computation, and the hierarchy."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as examples
from hypothesis import strategies as st

from checks.reference.algorithms import generate_key_frames, remerge
from mossar_adapters.demo import performance
from mossar_stream import FrameError, Segmenter, Settings, Skeleton, segment_recording
from mossar_stream.settings import Features

LEVELS = ("motion", 0.0, 0.05, 0.3, 1.0, 1.25, 2.0, 1e8)


def equation_1(positions, root, count):
    """Return the velocity: paths relative to the root over the last `count` displacements, summed over joints."""
    local = positions.astype(np.float64) - positions[:, root : root + 1].astype(np.float64)
    path = np.r_[0, np.linalg.norm(np.diff(local, axis=0), axis=2).sum(axis=1)]
    return np.array([path[max(0, t + 1 - count) : t + 1].sum() for t in range(len(path))])


def key_frames(V, theta):
    split = generate_key_frames(V, theta)
    return list(zip(split.key_frames, split.kinds, strict=True))


def settings_of(window, **others):
    return Settings(window=window, max_speed=1e4, level="posture", **others)


def streamed(positions, skeleton, fps, settings):
    segmenter = Segmenter(skeleton, settings, fps=fps)
    events = segmenter.push(positions) + segmenter.end_take()
    return [
        (e.frame, e.kind)
        for e in sorted(events, key=lambda e: getattr(e, "frame", -1))
        if e.__struct_config__.tag == "key_frame" and e.status == "final"
    ]


@pytest.mark.parametrize(("window", "theta"), [(1.0, 0.01), (0.25, 0.05)])
def test_cmu_86_01_is_segmented_frame_for_frame_as_the_oracle_does(walk_86_01, window, theta):
    positions, skeleton = walk_86_01
    V = equation_1(positions, skeleton.root, round(window * 120))
    settings = settings_of(
        window, sig_threshold=theta, range="fixed", range_max=float(V.max()), location="none"
    )
    expected = key_frames(V / V.max(), theta)
    assert len(expected) > 20
    assert streamed(positions, skeleton, 120.0, settings) == expected


def test_the_kinect_recordings_are_segmented_frame_for_frame_as_the_oracle_does(core, precog):
    found = 0
    for name, positions, fps in precog:
        skeleton = core.skeleton(positions.shape[1])
        V = equation_1(positions, 0, int(np.ceil(0.25 * fps - 1e-4)))
        settings = settings_of(
            0.25, sig_threshold=0.05, range="fixed", range_max=float(V.max()), location="none"
        )
        expected = key_frames(V / V.max(), 0.05)
        assert streamed(positions, skeleton, fps, settings) == expected, name
        found += len(expected)
    assert found > 300


def test_the_papers_preset_gives_algorithms_1_and_2_on_86_01(walk_86_01):
    positions, skeleton = walk_86_01
    V = equation_1(positions, skeleton.root, 120)
    V = (V - V.min()) / (V.max() - V.min())
    settings = Settings.build("paper", {"level": "posture", "range": "file"})
    result = segment_recording(positions, 120, skeleton, settings)
    assert [(k.frame, k.kind) for k in result.key_frames] == key_frames(V, 0.01)
    assert [k.frame for k in result.at("posture").key_frames] == [k.frame for k in result.key_frames]
    np.testing.assert_allclose(
        [k.velocity for k in result.key_frames], V[[k.frame for k in result.key_frames]]
    )


# Algorithm 3 with the likelihood, on whole arrays.


def likelihood_cost(positions, times, settings, pre, post):
    """Return the cost (a, k, b) -> merge cost of the likelihood, computed from the frames."""
    local = positions.astype(np.float64) - positions[:, :1]
    joints, dt = positions.shape[1], np.r_[0, np.minimum(np.diff(times), settings.max_gap)]
    others = np.arange(1, joints)
    half = max(1, joints // 2)
    a, b = np.array([(i, (i + k) % joints) for k in range(1, half + 1) for i in range(joints)]).T
    groups = [
        (local[:, others].reshape(len(local), -1), settings.features.positions, settings.variance_floor.positions),
        (np.linalg.norm(local[:, a] - local[:, b], axis=2), settings.features.distances, settings.variance_floor.distances),
    ]  # fmt: skip

    def samples(values, start, stop):
        part, weights = values[start:stop], dt[start:stop]
        if start == 0 and pre:
            part, weights = np.vstack([values[:1], part]), np.r_[pre, weights]
        if stop == len(values) and post:
            part, weights = np.vstack([part, values[-1:]]), np.r_[weights, post]
        return part, weights

    def term(start, stop):
        total, duration = 0.0, samples(local[:, 0], start, stop)[1].sum()
        if duration < 1e-6:
            return 0.0, duration
        for values, weight, floor in groups:
            part, w = samples(values, start, stop)
            mean = w @ part / w.sum()
            total += weight * np.log(w @ (part - mean) ** 2 / w.sum() + floor).mean()
        return duration * total, duration

    def cost(start, middle, stop):
        (left, n), (right, m), (both, _) = term(start, middle), term(middle, stop), term(start, stop)
        if min(n, m) < 1e-6:
            return 0.0
        short = settings.short_segment
        share = min(1, n / short) * min(1, m / short) if short else 1
        return max(both - left - right, 0.0) * share

    return cost


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    "rolls",
    [{}, {"pre_roll": 0.5, "post_roll": 0.5}, {"short_segment": 0.5}],
    ids=["plain", "rolls", "short"],
)
def test_strengths_are_those_of_plain_algorithm_3(core, seed, rolls):
    positions, times = core.moving_people(seed, frames=300, joints=5, losses=False)
    settings = Settings(
        window=0.05, range_floor=0.01, level=0.1, location="none", tempo=False, noise_margin=0.0, similarity="likelihood", rate_limit=0.0,
        features=Features(positions=0.6, distances=0.4), max_speed=1e4,
        **{"pre_roll": 0.0, "post_roll": 0.0, "short_segment": 0.0, **rolls},
    )  # fmt: skip
    result = segment_recording(positions, times=times, skeleton=core.skeleton(5), settings=settings)
    frames = [k.frame for k in result.key_frames]
    assert len(frames) > 10
    resolved = settings.resolved()
    cost = likelihood_cost(positions, times, resolved, resolved.pre_roll, resolved.post_roll)
    fallen = remerge(frames, 0, len(times), cost)
    assert [k.frame for k in result.hierarchy] == [frame for frame, _ in fallen]
    np.testing.assert_allclose([k.strength for k in result.hierarchy], [s for _, s in fallen], atol=1e-4)


# The hierarchy.


@examples(max_examples=30)
@given(st.integers(0, 10**6), st.sampled_from(["motion", "cluster", 0.02]))
def test_the_sets_are_nested_and_the_strengths_rise(core, seed, level):
    positions, times = core.moving_people(seed, frames=200)
    settings = Settings(level=level, range_floor=0.01, window=0.05)
    result = segment_recording(positions, times=times, skeleton=core.skeleton(4), settings=settings)
    strengths = [k.strength for k in result.hierarchy]
    assert strengths == sorted(strengths)
    assert sorted(k.frame for k in result.hierarchy) == [k.frame for k in result.key_frames]
    count = len(result.key_frames)
    sets = [len(result.at(count=k).key_frames) for k in range(count + 3)]
    assert sets == [*range(count + 1), count, count]


@pytest.mark.parametrize("seed", range(3))
def test_without_location_the_sets_are_subsets_of_one_another(core, seed):
    positions, times = core.moving_people(seed, frames=400)
    settings = Settings(location="none", range_floor=0.01, window=0.05)
    result = segment_recording(positions, times=times, skeleton=core.skeleton(4), settings=settings)
    count = len(result.key_frames)
    by_count = [{k.frame for k in result.at(count=k).key_frames} for k in range(count + 1)]
    assert all(small < large for small, large in itertools.pairwise(by_count))
    assert by_count[-1] == {k.frame for k in result.key_frames}
    for level in LEVELS:
        at = {k.frame for k in result.at(level).key_frames}
        assert at in by_count
        if isinstance(level, float):
            assert at == {k.frame for k in result.key_frames if k.strength >= level}


@pytest.mark.parametrize("level", LEVELS)
def test_segments_tile_the_recording_at_every_level(core, level):
    positions, times = core.moving_people(7, frames=400, losses=False)
    result = segment_recording(
        positions, times=times, skeleton=core.skeleton(4), settings=Settings(range_floor=0.01, window=0.05)
    )
    at = result.at(level)
    bounds = [0, *(k.frame for k in at.key_frames), 399]
    assert [(s.start_frame, s.end_frame) for s in at.segments] == list(itertools.pairwise(bounds))
    assert at.segments[0].similarity is None
    assert all(0 <= s.similarity <= 1 for s in at.segments[1:])


def test_at_least_max_key_frames_stand(core):
    positions, times = core.moving_people(3, frames=300, losses=False)
    for most in (0, 1, 5, 10**6):
        settings = Settings(level=1e8, max_key_frames=most, range_floor=0.01, window=0.05)
        result = segment_recording(positions, times=times, skeleton=core.skeleton(4), settings=settings)
        assert len(result.at(1e8).key_frames) == min(most, len(result.key_frames))


def test_asking_twice_gives_the_same_and_changes_nothing(core):
    positions, times = core.moving_people(4, frames=300)
    result = segment_recording(
        positions, times=times, skeleton=core.skeleton(4), settings=Settings(range_floor=0.01)
    )
    first = [result.at(level) for level in LEVELS]
    assert [result.at(level) for level in LEVELS] == first
    assert result.segments == result.at("motion").segments


def test_at_takes_a_level_or_a_count(core):
    result = segment_recording(np.zeros((5, 2, 3)), 30, core.PAIR)
    for wrong in ({}, {"level": 0.1, "count": 1}, {"count": -1}):
        with pytest.raises(ValueError, match=r"level|count"):
            result.at(**wrong)


# What there is little to find in.


def test_an_empty_recording_and_one_of_a_frame_have_no_key_frames(core):
    empty = segment_recording(np.zeros((0, 2, 3)), 30, core.PAIR)
    assert (empty.key_frames, empty.hierarchy, empty.segments) == ([], [], [])
    one = segment_recording(np.zeros((1, 2, 3)), 30, core.PAIR)
    assert one.key_frames == []
    assert [(s.start_frame, s.end_frame) for s in one.segments] == [(0, 0)]


@pytest.mark.parametrize(
    "positions",
    [
        np.zeros((90, 4, 3)),
        np.full((90, 4, 3), np.nan),
        np.full((90, 4, 3), np.inf),
        np.full((90, 4, 3), 1e30),
        np.repeat(np.random.default_rng(0).normal(0, 1, (90, 1, 3)), 4, axis=1),
    ],
    ids=["constant", "nan", "inf", "huge", "duplicate joints"],
)
@pytest.mark.filterwarnings("ignore:.*there is nothing to segment")
@pytest.mark.parametrize("similarity", ["likelihood", "path_kernel"])
def test_degenerate_recordings_give_no_nan_and_no_crash(core, positions, similarity):
    settings = Settings(similarity=similarity, range="file")
    result = segment_recording(positions, 30, core.skeleton(4), settings)
    assert all(np.isfinite([k.velocity, k.strength, k.time]).all() for k in result.key_frames)
    assert [result.at(level).segments for level in LEVELS]


@pytest.mark.parametrize("similarity", ["likelihood", "path_kernel"])
def test_two_segments_alike_and_segments_of_one_frame_are_finite(core, similarity):
    curve = np.r_[np.tile([0, 8, 8, 8, 0, 0], 6), np.tile([0, 8], 10)] / 16
    settings = Settings(**{**core.ONE_STEP, "sig_threshold": 0.1, "similarity": similarity})
    result = segment_recording(core.hand_steps(curve), core.FPS, core.PAIR, settings)
    assert len(result.key_frames) > 20
    assert np.isfinite([k.strength for k in result.key_frames]).all()
    assert min(k.strength for k in result.key_frames) >= 0


def test_500_joints(core):
    rng = np.random.default_rng(0)
    positions = np.cumsum(rng.normal(0, 0.02, (60, 500, 3)), axis=0)
    positions[30:50] = positions[30]
    result = segment_recording(positions, 30, core.skeleton(500), Settings(level="cluster", range_floor=0.01))
    assert result.key_frames
    assert np.isfinite([k.strength for k in result.key_frames]).all()


def test_unnamed_joints_move_around_their_centroid():
    positions = np.random.default_rng(1).normal(0, 0.1, (50, 3, 3)).cumsum(axis=0)
    named = segment_recording(positions, 30, Skeleton(("joint0", "joint1", "joint2"), root=-1))
    unnamed = segment_recording(positions, 30)
    assert named.key_frames == unnamed.key_frames
    assert named.segments == unnamed.segments


def test_a_recording_is_one_take_whatever_its_times_do(core):
    positions, _ = core.moving_people(5, frames=100, losses=False)
    times = np.arange(100) / 60
    times[30:] += 1000
    times[[50, 60]] = [np.inf, 3.0]
    times[70] = np.nan
    result = segment_recording(
        positions, times=times, skeleton=core.skeleton(4), settings=Settings(range_floor=0.01)
    )
    assert result.segments[0].start_frame == 0
    assert result.segments[-1].end_frame == 99


def test_many_key_frames_make_room_for_themselves(core):
    curve = np.tile([0, 8, 4, 8], 400) / 16
    result = segment_recording(
        core.hand_steps(curve), core.FPS, core.PAIR, Settings(**{**core.ONE_STEP, "sig_threshold": 1 / 16})
    )
    assert [(k.frame, k.kind) for k in result.key_frames] == key_frames(curve, 1 / 16)
    assert len(result.key_frames) > 1000


def test_the_curve_is_kept_where_it_is_asked_for(core):
    curve = np.array([0, 4, 8, 2, 8]) / 16
    result = segment_recording(
        core.hand_steps(curve),
        core.FPS,
        core.PAIR,
        Settings(**{**core.ONE_STEP, "sig_threshold": 1 / 16}),
        curves=True,
    )
    assert [state.value for state in result.curves] == curve.tolist()
    assert segment_recording(core.hand_steps(curve), core.FPS, core.PAIR).curves == []


def test_what_does_not_fit_is_refused_with_one_line(core):
    for positions, arguments in [
        (np.zeros((5, 2)), {"fps": 30}),
        (np.zeros((5, 0, 3)), {"fps": 30}),
        (np.zeros((5, 3, 3)), {"fps": 30, "skeleton": core.PAIR}),
        (np.zeros((5, 2, 3)), {"times": np.arange(4)}),
    ]:
        with pytest.raises(FrameError):
            segment_recording(positions, **arguments)
    with pytest.raises(ValueError, match="fps or times"):
        segment_recording(np.zeros((5, 2, 3)))


@pytest.mark.parametrize("level", ["motion", "posture"])
def test_the_curve_tells_where_its_key_frames_stand(level):
    take = performance(fps=60.0, seconds=20.0)
    settings = Settings(level=level, location="none")
    result = segment_recording(take.frames.positions, 60.0, take.skeleton, settings, curves=True)
    reported = np.array([state.reported_time for state in result.curves])
    value = np.array([state.value for state in result.curves])
    with pytest.warns(DeprecationWarning, match="reported_time"):
        assert result.curves[-1].told == reported[-1]
    assert (reported <= [state.time for state in result.curves]).all()
    minima = [key for key in result.key_frames if key.kind == "minimum"]
    assert len(minima) > 10
    heights = np.interp([key.time for key in minima], np.maximum.accumulate(reported), value)
    assert heights == pytest.approx([key.velocity for key in minima], abs=1e-3)
