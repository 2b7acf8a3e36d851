"""The segmenter as its users see it: any chopping, any snapshot, any kind of array, the same events."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as examples
from hypothesis import strategies as st

from mossar_stream import FrameError, Frames, Segmenter, Settings, SettingsError, Skeleton

KINDS = [
    {},
    {"level": "cluster"},
    {"smoothing": "one_euro", "remerge_window": 2, "remerge_seconds": 0.3, "level": 0.05},
    {"smoothing": "moving_average", "smoothing_window": 4, "range": "decay", "center": "centroid"},
    {"window": 0.05, "range_floor": 0.001, "sig_threshold": 0.01, "noise_margin": 0.0, "level": 0.02},
    {"window": 1.0, "range": "fixed", "range_max": 2.0, "remerge_seconds": 0.1, "remerge_window": 1},
]


def run(core, seed, kind, sizes):
    positions, times = core.moving_people(seed)
    segmenter = Segmenter(core.skeleton(4), Settings(**kind))
    return core.lines(core.events_in_chunks(segmenter, positions, times, sizes)), segmenter.stats


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_any_chopping_gives_the_same_bytes_and_counts(core, kind, seed):
    whole = run(core, seed, kind, (10**6,))
    assert len(whole[0]) > 6
    for sizes in ((1,), (7,), (64,), (3, 50, 1, 11)):
        assert run(core, seed, kind, sizes) == whole


@pytest.mark.parametrize("kind", KINDS)
def test_a_snapshot_after_every_frame_changes_nothing(core, kind):
    positions, times = core.moving_people(5, frames=120)
    segmenter = Segmenter(core.skeleton(4), Settings(**kind), performer="ann")
    events = []
    for frame, time in zip(positions, times, strict=True):
        events += segmenter.push(frame, time)
        segmenter = Segmenter.restore(segmenter.snapshot())
    whole = Segmenter(core.skeleton(4), Settings(**kind), performer="ann")
    assert core.lines(events + segmenter.end_take()) == core.lines(
        whole.push(positions, times) + whole.end_take()
    )
    assert segmenter.stats == whole.stats
    assert segmenter.settings == whole.settings


@examples(max_examples=25)
@given(st.integers(0, 10**6), st.lists(st.integers(1, 90), min_size=1, max_size=6), st.sampled_from(KINDS))
def test_people_at_random_chopped_at_random(core, seed, sizes, kind):
    assert run(core, seed, kind, sizes) == run(core, seed, kind, (10**6,))


@examples(max_examples=25)
@given(st.integers(0, 10**6), st.integers(1, 239), st.sampled_from(KINDS), st.floats(0, 2))
def test_levels_moved_between_frames_survive_a_snapshot(core, seed, cut, kind, level):
    positions, times = core.moving_people(seed)
    lines = []
    for restored in (False, True):
        segmenter = Segmenter(core.skeleton(4), Settings(**kind))
        events = segmenter.push(positions[:cut], times[:cut])
        segmenter.level = level
        if restored:
            segmenter = Segmenter.restore(segmenter.snapshot())
            assert segmenter.level == level
        events += segmenter.push(positions[cut:], times[cut:]) + segmenter.end_take()
        lines.append(core.lines(events))
    assert lines[0] == lines[1]


def test_a_snapshot_leaves_the_segmenter_undisturbed(core):
    positions, times = core.moving_people(1)
    segmenter = Segmenter(core.skeleton(4))
    events = segmenter.push(positions[:100], times[:100])
    twin = Segmenter.restore(segmenter.snapshot())
    assert segmenter.snapshot() == segmenter.snapshot() == twin.snapshot()
    rest = [core.lines(s.push(positions[100:], times[100:]) + s.end_take()) for s in (segmenter, twin)]
    assert rest[0] == rest[1]
    assert events


ARRAYS = {
    "float64": lambda a: a.astype(np.float64),
    "big endian": lambda a: a.astype(">f4"),
    "column major": np.asfortranarray,
    "every other of a larger one": lambda a: np.repeat(a, 2, axis=0)[::2],
    "backwards twice": lambda a: a[::-1].copy()[::-1],
    "a list": lambda a: a.tolist(),
    "with holes": lambda a: np.ma.masked_invalid(a).filled(np.nan),
}


@pytest.mark.parametrize("make", ARRAYS.values(), ids=ARRAYS)
def test_any_array_is_taken(core, make):
    positions, times = core.moving_people(2)
    expected = core.lines(Segmenter(core.skeleton(4)).push(positions, times))
    assert core.lines(Segmenter(core.skeleton(4)).push(make(positions), times)) == expected
    one_by_one = Segmenter(core.skeleton(4))
    frames = make(positions)
    assert core.lines(e for i in range(len(times)) for e in one_by_one.push(frames[i], times[i])) == expected


def test_read_only_arrays_are_taken_and_never_written(core):
    positions, times = core.moving_people(2)
    before = positions.copy(), times.copy()
    positions.flags.writeable = times.flags.writeable = False
    segmenter = Segmenter(core.skeleton(4))
    for i in range(len(times)):
        segmenter.push(positions[i], times[i])
    segmenter.push(positions, times)
    np.testing.assert_array_equal(positions, before[0])
    np.testing.assert_array_equal(times, before[1])


def test_the_callers_arrays_are_not_kept(core):
    positions, times = core.moving_people(2)
    kept = Segmenter(core.skeleton(4))
    buffer, moment = np.empty((4, 3), np.float32), np.empty(1)
    events = []
    for i in range(len(times)):
        buffer[:], moment[:] = positions[i], times[i]
        events += kept.push(buffer, moment)
        buffer[:], moment[:] = 77.0, -1.0
    assert core.lines(events) == core.lines(Segmenter(core.skeleton(4)).push(positions, times))


@pytest.mark.parametrize(
    "make", [float, np.float64, np.float32, int, np.array, lambda t: [t], lambda t: np.array([t])]
)
def test_a_time_may_be_a_number_of_any_kind(core, make):
    segmenter = Segmenter(core.PAIR)
    for t in range(3):
        segmenter.push(np.zeros((2, 3), np.float32), make(t))
    assert segmenter.stats["frames"] == 3
    assert segmenter.stats["out_of_order"] == 0


def test_times_follow_from_the_rate_where_none_are_given(core):
    positions, _ = core.moving_people(3, losses=False)
    by_rate = Segmenter(core.skeleton(4), fps=60.0)
    chunks = [by_rate.push(positions[i : i + 13]) for i in range(0, len(positions), 13)]
    by_times = Segmenter(core.skeleton(4)).push(positions, np.arange(len(positions)) / 60.0)
    assert core.lines(event for chunk in chunks for event in chunk) == core.lines(by_times)


def test_a_jump_of_the_first_frame_is_a_jump_in_time_where_the_rate_gives_the_times(core):
    segmenter = Segmenter(core.PAIR, fps=10.0)
    segmenter.push(np.zeros((3, 2, 3)))
    segmenter.push(np.zeros((1, 2, 3)), first_frame=9)
    assert (segmenter.state.frame, segmenter.state.time) == (9, 0.9)
    assert segmenter.stats["gaps"] == 1


def test_frames_are_pushed_like_their_parts(core):
    positions, times = core.moving_people(4)
    sure = (np.random.default_rng(0).random(positions.shape[:2]) > 0.1).astype(np.float32)
    frames = Frames(positions, times, sure, "p1", 1000)
    expected = core.lines(Segmenter(core.skeleton(4)).push(positions, times, sure, 1000))
    assert core.lines(Segmenter(core.skeleton(4)).push(frames)) == expected


def test_no_confidence_is_a_missing_joint(core):
    positions, times = core.moving_people(4, losses=False)
    sure = np.ones(positions.shape[:2], np.float32)
    sure[50:70, 2] = 0
    sure[100:103] = np.nan
    missing = np.where(sure[:, :, None] > 0, positions, np.nan)
    expected = core.lines(Segmenter(core.skeleton(4)).push(missing, times))
    assert core.lines(Segmenter(core.skeleton(4)).push(positions, times, sure)) == expected


def test_frame_numbers_go_on_from_the_first_frame_given(core):
    curve = np.array([0, 0, 8, 8, 0, 0]) / 16
    frames, times = core.hand_steps(curve), np.arange(6) / core.FPS
    segmenter = core.segmenter_of({}, 1 / 16)
    events = segmenter.push(frames[:3], times[:3], first_frame=500) + segmenter.push(frames[3:], times[3:])
    assert [e.frame for e in core.key_frames(events, "confirmed")] == [502, 504]
    assert core.key_frames(events, "confirmed")[0].id == "p1/0/502"


def test_a_first_frame_holds_for_the_whole_chunk_even_if_a_take_ends_in_it(core):
    curve = np.array([0, 0, 8, 8, 0, 0, 0, 8, 8, 8]) / 16
    frames, times = core.hand_steps(curve), np.arange(10) / core.FPS
    times[5:] += 10
    whole, chopped = core.segmenter_of({}, 1 / 16), core.segmenter_of({}, 1 / 16)
    events = whole.push(frames, times, first_frame=100)
    pieces = [chopped.push(frames[i : i + 1], times[i : i + 1], first_frame=100 + i) for i in range(10)]
    assert core.lines(events) == core.lines(event for piece in pieces for event in piece)
    assert [(e.take, e.frame) for e in core.key_frames(events, "confirmed")] == [(0, 102), (0, 104), (1, 107)]


def test_what_does_not_fit_is_refused_with_one_line(core):
    segmenter = Segmenter(core.PAIR)
    for positions, times in [
        (np.zeros((3, 3)), 0.0),
        (np.zeros((1, 3, 3)), [0.0]),
        (np.zeros((2, 2, 3)), [0.0]),
        (np.zeros((2, 2, 3)), [[0.0, 1.0]]),
        (np.zeros(6), 0.0),
        (np.zeros((1, 1, 2, 3)), [0.0]),
    ]:
        with pytest.raises(FrameError) as refused:
            segmenter.push(positions, times)
        assert "\n" not in str(refused.value)
    for sure in (np.ones((2, 3)), np.ones(4), np.ones((3, 2))):
        with pytest.raises(FrameError, match="confidence"):
            segmenter.push(np.zeros((2, 2, 3)), [0.0, 0.1], confidence=sure)
    with pytest.raises(ValueError, match="times"):
        segmenter.push(np.zeros((2, 2, 3)))
    assert segmenter.stats["frames"] == 0


@pytest.mark.parametrize("fps", [0, -1, np.nan, np.inf])
def test_an_impossible_rate_is_refused(core, fps):
    with pytest.raises(ValueError, match="fps must be a positive number"):
        Segmenter(core.PAIR, fps=fps)


def test_the_range_of_a_file_is_refused_on_a_stream(core):
    with pytest.raises(ValueError, match="range=file needs a whole recording"):
        Segmenter(core.PAIR, Settings(range="file"))


@pytest.mark.parametrize("level", ["loud", -1.0, np.nan, np.inf])
def test_an_impossible_level_is_refused_and_the_old_one_stays(core, level):
    segmenter = Segmenter(core.PAIR)
    with pytest.raises(SettingsError, match="level"):
        segmenter.level = level
    assert segmenter.level == "motion"


def test_no_frames_are_no_events(core):
    segmenter = Segmenter(core.PAIR)
    assert segmenter.push(np.zeros((0, 2, 3), np.float32), np.zeros(0)) == []
    assert segmenter.end_take() == []
    assert segmenter.state is None
    assert segmenter.stats["frames"] == 0


def test_one_frame_is_a_take_with_one_segment(core):
    segmenter = Segmenter(core.PAIR)
    events = segmenter.push(np.ones((2, 3), np.float32), 3.0) + segmenter.end_take("done")
    assert [e.__struct_config__.tag for e in events] == ["stream", "segment", "stream"]
    assert (events[1].start_frame, events[1].end_frame, events[1].status) == (0, 0, "final")
    assert events[2].reason == "done"
    assert segmenter.take == 1


@pytest.mark.parametrize("joints", [1, 2, 7, 8, 9, 33, 500])
def test_any_number_of_joints(core, joints):
    rng = np.random.default_rng(joints)
    positions = np.cumsum(rng.normal(0, 0.02, (60, joints, 3)), axis=0).astype(np.float32)
    positions[20:40] = positions[20]
    segmenter = Segmenter(core.skeleton(joints), Settings(range_floor=0.01), fps=30.0)
    events = segmenter.push(positions) + segmenter.end_take()
    assert events[0].event == "started"
    assert events[-1].event == "ended"
    assert len(core.key_frames(events, "confirmed")) >= (0 if joints == 1 else 2)


@pytest.mark.filterwarnings("ignore:performer p1 is:UserWarning")  # nobody is that large
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e30, 3e38])
def test_no_number_makes_a_state_that_is_none(core, bad):
    positions, times = core.moving_people(6, losses=False)
    rng = np.random.default_rng(0)
    positions[rng.random(positions.shape) < 0.05] = bad
    segmenter = Segmenter(core.skeleton(4))
    events = segmenter.push(positions, times)
    assert np.isfinite(segmenter.state.value)
    assert np.isfinite(segmenter.state.scale)
    assert np.isfinite(segmenter.state.pose).all()
    events += segmenter.push(np.full((9, 4, 3), bad), times[-1] + 1 + times[:9])
    events += segmenter.end_take()
    assert b"nan" not in b"".join(core.lines(events)).lower()


def test_frames_of_nothing_but_nan_begin_no_take(core):
    segmenter = Segmenter(core.PAIR, fps=30.0)
    assert segmenter.push(np.full((60, 2, 3), np.nan)) + segmenter.end_take() == []


def test_a_reset_ends_the_take_and_forgets_the_range(core):
    fast, slow = np.array([0.0] + [16.0] * 9), np.array([0.0] + [0.5] * 9)
    settings = Settings(
        window=1 / core.FPS,
        sig_threshold=0.1,
        range_floor=0.0,
        max_speed=1e4,
        noise_margin=0.0,
        similarity="likelihood",
    )
    segmenter = Segmenter(core.PAIR, settings, fps=core.FPS)
    first = segmenter.push(core.hand_steps(fast))
    events = segmenter.reset("another person")
    assert [e.event for e in events if e.__struct_config__.tag == "stream"] == ["ended", "reset"]
    assert events[-1].reason == "another person"
    again = segmenter.push(core.hand_steps(slow))
    assert [len(core.key_frames(e, "confirmed")) for e in (first, again)] == [1, 1]
    assert segmenter.take == 1


def test_a_change_of_the_level_alone_goes_on_and_one_of_the_window_starts_a_new_take(core):
    positions, times = core.moving_people(7, losses=False)
    segmenter = Segmenter(core.skeleton(4))
    segmenter.push(positions[:50], times[:50])
    assert segmenter.change(level=0.7) == []
    assert (segmenter.level, segmenter.take) == (0.7, 0)
    events = segmenter.change(window=0.5)
    assert events[-1].event == "ended"
    assert (segmenter.settings.window, segmenter.level, segmenter.take) == (0.5, 0.7, 1)
    assert segmenter.push(positions[50:], times[50:])[0].event == "started"
    assert segmenter.stats["frames"] == len(times)
    with pytest.raises(SettingsError):
        segmenter.change(window=-1.0)
    assert segmenter.settings.window == 0.5


def test_a_tempo_that_was_not_followed_from_the_start_is_not_used(core):
    positions, times = core.moving_people(7, frames=400, losses=False)
    segmenter = Segmenter(core.skeleton(4), Settings(level="posture", tempo=False))
    segmenter.push(positions[:200], times[:200])
    assert segmenter.change(tempo=True)[-1].event == "ended"
    segmenter.push(positions[200:], times[200:])
    fresh = Segmenter(core.skeleton(4), Settings(level="posture", tempo=True))
    fresh.push(positions[200:], times[200:])
    assert [segmenter.row.state["tempo"][name] for name in ("spread", "squared_speed")] == [
        fresh.row.state["tempo"][name] for name in ("spread", "squared_speed")
    ]


def test_a_performers_name_is_made_fit_for_ids():
    segmenter = Segmenter(Skeleton(("hip",)), performer="a b/c.d")
    assert segmenter.performer == "a_b_c_d"


def test_a_clock_far_too_slow_takes_no_memory_without_end(core):
    segmenter = Segmenter(core.skeleton(4), Settings(rate_limit=0.0), fps=60.0)
    frames, times = core.moving_people(1, 60_000, 4, losses=False)[0], np.arange(60_000) * 1e-9
    segmenter.push(frames, times)
    assert len(segmenter.snapshot()) < 1 << 20
    assert segmenter.stats["frames"] == 60_000
    assert segmenter.stats["out_of_order"] > 30_000
    later = segmenter.push(frames[:600], 1.0 + np.arange(600) / 60.0)
    assert core.key_frames(later, "confirmed"), "it goes on when the clock is right"


@pytest.mark.parametrize("size", [1, 64])
def test_a_take_without_anybody_says_so_once(core, size):
    segmenter = Segmenter(core.skeleton(4), fps=60.0)
    frames = np.zeros((200, 4, 3))
    events = core.events_in_chunks(segmenter, frames, np.arange(200) / 60.0, [size])
    said = [event for event in events if "nobody seen" in getattr(event, "reason", "")]
    assert [event.event for event in said] == ["ended"]
    assert segmenter.end_take() == []


def test_a_take_with_somebody_does_not_say_that_nobody_was_there(core):
    positions, times = core.moving_people(1, frames=100)
    positions[:20] = 0.0  # until somebody comes
    segmenter = Segmenter(core.skeleton(4), fps=60.0)
    events = [*segmenter.push(positions, times), *segmenter.end_take("done")]
    assert [event.reason for event in events if getattr(event, "event", "") == "ended"] == ["done"]
