"""Activity: moving or resting, said at once and rightly; when segments were active; holds and rests as segments."""

from itertools import pairwise

import numpy as np
import pytest

from mossar_adapters.demo import performance
from mossar_stream import (
    ActivityEvent,
    KeyFrameEvent,
    Performers,
    Segmenter,
    SegmentEvent,
    Settings,
    SettingsError,
    Skeleton,
    segment_recording,
    to_json,
)

FPS = 30.0
# A trunk of six joints that stand, and an arm of four.
NAMES = ("hip", "chest", "head", "left", "right", "foot", "shoulder", "elbow", "wrist", "hand")
BODY = Skeleton(NAMES, (-1, 0, 1, 0, 0, 0, 1, 6, 7, 8))
RAISE, HOLD = 0.8, 1.0  # s
SETTINGS = [Settings(level=level) for level in ("posture", "motion", "cluster")]
SETTINGS += [Settings.build("paper"), Settings.build("game"), Settings(similarity="path_kernel")]
IDS = ("posture", "motion", "cluster", "paper", "game", "path_kernel")


def raising(times, spans, noise=0.0, seed=0):
    """Return poses in which the arm goes up and down by turns in some spans, s, and waits between."""
    up = np.zeros(len(times))
    for k, (begin, end) in enumerate(spans):
        share = np.clip((times - begin) / (end - begin), 0.0, 1.0)
        way = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)  # minimum jerk
        up += way if k % 2 == 0 else -way
    poses = np.zeros((len(times), len(NAMES), 3), np.float32)
    poses[:, :, 1] = np.linspace(0.0, 1.0, len(NAMES))
    for joint, reach in ((7, 0.25), (8, 0.5), (9, 0.7)):
        poses[:, joint, 1] += reach * up
    return poses + np.random.default_rng(seed).normal(0.0, noise, poses.shape).astype(np.float32)


def four_holds(noise=0.0, fps=FPS):
    """Return poses, times and the 16 moments at which raises, holds, ways down and rests begin and end."""
    cuts = 1.0 + np.cumsum([0.0, *[RAISE, HOLD] * 8])[:16]
    times = np.arange(int((cuts[-1] + 1.0) * fps)) / fps
    spans = list(zip(cuts[::2], cuts[1::2], strict=True))
    return raising(times, spans, noise), times, cuts


def streamed(poses, times, settings=None, chunk=None, performer="p1"):
    segmenter = Segmenter(BODY, settings, performer, fps=1.0 / (times[1] - times[0]))
    size = chunk or len(times)
    events = [
        event
        for begin in range(0, len(times), size)
        for event in segmenter.push(poses[begin : begin + size], times[begin : begin + size])
    ]
    return events + segmenter.end_take()


def activity(events, channel="body"):
    return [e for e in events if isinstance(e, ActivityEvent) and e.channel == channel]


@pytest.mark.parametrize("settings", SETTINGS, ids=IDS)
def test_every_bout_has_one_moving_and_one_resting_at_every_level_and_preset(settings):
    poses, times, cuts = four_holds()
    found = activity(streamed(poses, times, settings))
    assert [e.state for e in found] == ["moving", "resting"] * 8
    assert np.abs(np.array([e.start for e in found]) - cuts).max() < 0.25
    for event in found:
        late = event.decided_time - event.start
        assert late <= 0.1 if event.state == "moving" else 0.25 - 1e-6 <= late <= 0.25 + 1.5 / FPS


def test_an_event_says_how_long_what_ended_has_lasted_and_numbers_the_changes():
    poses, times, _ = four_holds()
    found = activity(streamed(poses, times))
    assert [e.id for e in found] == [f"p1/activity/0/{k}" for k in range(1, 17)]
    assert found[0].previous is None
    for before, after in pairwise(found):
        assert after.previous == pytest.approx(after.start - before.start)
    line = to_json(found[0])
    assert b'"previous":null' in line
    assert b'"limb":null' in line
    assert b"channel" not in line


def test_a_turning_point_is_no_rest():
    played = performance(3, fps=FPS, moves=("rest:2", "squat", "rest:2", "walk", "rest:2"))
    segmenter = Segmenter(played.skeleton, fps=FPS)
    events = segmenter.push(played.frames) + segmenter.end_take()
    assert [e.state for e in activity(events)] == ["moving", "resting"] * 2
    offsets = [e for e in events if isinstance(e, KeyFrameEvent) and e.kind == "offset"]
    assert len({e.id for e in offsets}) > 2  # where the velocity dips below the line


@pytest.mark.parametrize("settings", SETTINGS, ids=IDS)
def test_a_noisy_sensor_does_not_move_somebody_who_stands(settings):
    for kind in ("white", "kinect"):
        played = performance(1, fps=FPS, moves=("stand:60",), noise=0.005, noise_kind=kind)
        segmenter = Segmenter(played.skeleton, settings.replace(limbs=kind == "white"), fps=FPS)
        events = segmenter.push(played.frames) + segmenter.end_take()
        assert not [e for e in events if isinstance(e, ActivityEvent)]


def test_movements_are_found_in_noise():
    for noise in (0.001, 0.003, 0.005):
        poses, times, cuts = four_holds(noise)
        found = activity(streamed(poses, times))
        assert [e.state for e in found] == ["moving", "resting"] * 8
        assert np.abs(np.array([e.start for e in found]) - cuts).max() < 0.4


def test_the_setting_says_how_long_a_rest_is():
    times = np.arange(200) / FPS
    poses = raising(times, [(1.0, 1.8), (2.4, 3.2)])
    bouts = {s: len(activity(streamed(poses, times, Settings(rest_seconds=s)))) // 2 for s in (0.25, 1.0)}
    assert bouts == {0.25: 2, 1.0: 1}
    with pytest.raises(SettingsError, match="rest_seconds"):
        Settings(rest_seconds=0.0)
    with pytest.raises(SettingsError, match="rests is 'hold'; it must be one of merge, keep"):
        Settings(rests="hold")


@pytest.mark.parametrize("settings", [*SETTINGS, Settings(rests="keep", limbs=True)], ids=[*IDS, "keep"])
def test_frames_may_be_cut_in_any_way_and_a_snapshot_goes_on_exactly(settings):
    poses, times, _ = four_holds(0.003)
    once = [to_json(e) for e in streamed(poses, times, settings)]
    for chunk in (1, 7, 64):
        assert [to_json(e) for e in streamed(poses, times, settings, chunk)] == once
    segmenter, found = Segmenter(BODY, settings, fps=FPS), []
    for i in range(len(times)):
        found += segmenter.push(poses[i], float(times[i]))
        if i % 5 == 0:
            segmenter = Segmenter.restore(segmenter.snapshot())
    assert [to_json(e) for e in found + segmenter.end_take()] == once


def test_each_limb_has_its_own_and_the_body_says_which_woke_it():
    poses, times, _ = four_holds()
    events = streamed(poses, times, Settings(limbs="arm=elbow,wrist,hand;head=head"))
    arm = activity(events, "arm")
    assert [e.state for e in arm] == ["moving", "resting"] * 8
    assert arm[0].id == "p1/arm/activity/0/1"
    assert not activity(events, "head")
    assert {e.limb for e in activity(events)} == {"arm"}


def test_limbs_that_come_in_later_are_named_from_then_on():
    poses, times, _ = four_holds()
    segmenter = Segmenter(BODY, fps=FPS)
    before = segmenter.push(poses[:120], times[:120])
    segmenter.change(limbs="arm=elbow,wrist,hand")
    after = segmenter.push(poses[120:], times[120:])
    assert {e.limb for e in activity(before)} == {None}
    assert {e.limb for e in activity(after)} == {"arm"}


def test_many_performers_have_their_own():
    poses, times, _ = four_holds()
    performers = Performers()
    for name in ("a", "b"):
        performers.announce(name, BODY, FPS)
    events = performers.push_many(["a", "b"], np.stack([poses, poses[::-1]]), times)
    alone = activity(streamed(poses, times, performer="a"))
    assert [e for e in activity(events) if e.performer == "a"] == alone
    assert len(activity(events)) == 32


def test_a_take_begins_at_rest_and_a_rest_that_has_begun_is_reported_at_its_end():
    poses, times, _ = four_holds()
    segmenter = Segmenter(BODY, fps=FPS)
    still = int(2.1 * FPS)  # 0.3 s into the first hold, after its report
    found = activity(segmenter.push(poses[: still - 5], times[: still - 5]) + segmenter.end_take())
    assert [e.state for e in found] == ["moving", "resting"]
    assert found[1].decided_time - found[1].start < 0.25
    found = activity(segmenter.push(poses[45:55], times[45:55]) + segmenter.end_take())
    assert [(e.state, e.id, e.previous) for e in found] == [("moving", "p1/activity/1/1", None)]


def test_a_segment_is_resting_only_if_nothing_moved_in_it():
    poses, times, _ = four_holds()
    for settings in (Settings(), Settings(rests="keep"), Settings(level="posture")):
        segments = [e for e in streamed(poses, times, settings) if isinstance(e, SegmentEvent)]
        for event in segments:
            assert (event.state == "resting") == (event.active_start is None) == (event.active_end is None)
            if event.active_start is not None:
                assert event.start_time <= event.active_start <= event.active_end <= event.end_time
            if event.status == "final" and event.state == "resting":
                inside = (times > event.start_time) & (times < event.end_time)
                assert np.ptp(poses[inside, 9, 1]) < 0.05  # m: the hand
    line = to_json(next(e for e in segments if e.state == "resting"))
    assert b'"active_start":null,"active_end":null' in line


@pytest.mark.parametrize("fps", [30.0, 60.0])
@pytest.mark.parametrize("noise", [0.0, 0.001, 0.003])
def test_holds_and_rests_are_kept_as_segments_with_both_ends_as_key_frames(noise, fps):
    poses, times, cuts = four_holds(noise, fps)
    events = streamed(poses, times, Settings(rests="keep"))
    found = sorted(e.time for e in events if isinstance(e, KeyFrameEvent) and e.status == "final")
    assert len(found) == len(cuts)
    assert np.abs(np.array(found) - cuts).max() < 0.25
    states = [e.state for e in events if isinstance(e, SegmentEvent) and e.status == "final"]
    assert states == ["resting", "moving"] * 8 + ["resting"]


@pytest.mark.parametrize("noise", [0.01, 0.02])
def test_noise_as_fast_as_a_movement_judges_no_rest(noise):
    poses, times, _ = four_holds(noise)
    kept, merged = (streamed(poses, times, Settings(rests=rests)) for rests in ("keep", "merge"))
    finals = [
        [(e.id, e.time) for e in own if isinstance(e, KeyFrameEvent) and e.decided] for own in (kept, merged)
    ]
    assert finals[0] == finals[1]


def test_merging_lets_the_level_decide():
    poses, times, _ = four_holds(0.003)
    events = streamed(poses, times, Settings(rests="merge"))
    found = [e for e in events if isinstance(e, KeyFrameEvent) and e.status == "final"]
    assert len(found) < 14


def test_a_recording_keeps_rests_as_a_stream_does_and_its_segments_know_when_they_were_active():
    poses, _, cuts = four_holds(0.001)
    result = segment_recording(poses, FPS, BODY, Settings(rests="keep"))
    found = result.at("motion")
    assert np.abs(np.array([key.time for key in found.key_frames]) - cuts).max() < 0.25
    assert [part.state for part in found.segments] == ["resting", "moving"] * 8 + ["resting"]
    assert [part.active_start is None for part in found.segments] == [True, False] * 8 + [True]


def test_more_bouts_than_a_stream_remembers_leave_the_first_and_the_last_moment():
    times = np.arange(int(32 * FPS)) / FPS
    poses = raising(times, [(2.0 * k + 1.0, 2.0 * k + 1.5) for k in range(15)])
    events = streamed(poses, times, Settings(level=1e6))  # one segment, with all bouts
    bouts = activity(events)
    (whole,) = [e for e in events if isinstance(e, SegmentEvent) and e.status == "final"]
    assert (whole.active_start, whole.active_end) == (bouts[0].start, bouts[-1].start)


def jumping(noise, fps, way, is_even, at):
    """Return poses that stand until the time `at`, s, and in which the arm is somewhere else from then on."""
    times = np.arange(int(6.0 * fps)) / fps
    random = np.random.default_rng(0)
    poses = np.zeros((len(times), len(NAMES), 3))
    poses[:, :, 1] = np.linspace(0.0, 1.0, len(NAMES))
    for joint, reach in ((7, 0.25), (8, 0.5), (9, 0.7)):
        poses[times >= at - 1e-9, joint, 0] += way * reach
    if is_even:  # each frame is as far to the other side of the truth as the last one
        poses += np.where(np.arange(len(times)) % 2, -noise, noise)[:, None, None] * random.normal(
            size=poses.shape[1:]
        )
    else:
        poses += random.normal(0.0, noise, poses.shape)
    return poses.astype(np.float32), times


@pytest.mark.parametrize("settings", SETTINGS, ids=IDS)
@pytest.mark.parametrize(
    ("noise", "is_even", "rates"),
    [(0.0, True, (5.0, 10.0, 30.0, 60.0)), (0.001, True, (30.0, 60.0)), (0.001, False, (30.0,))],
    ids=["exactly still", "even noise", "white noise"],
)
def test_a_jump_in_one_frame_is_a_movement_of_the_segment_in_which_it_lies(settings, noise, is_even, rates):
    for fps in rates:
        for way, at in ((0.15, 3.0), (0.4, 3.0), (0.4, 0.6)):
            events = streamed(*jumping(noise, fps, way, is_even, at), settings)
            found = activity(events)
            assert [e.state for e in found] == ["moving", "resting"]
            assert at - 1e-6 <= found[0].start <= at + 0.067
            assert found[0].decided_time - found[0].start <= 0.1
            parts = [e for e in events if isinstance(e, SegmentEvent) and e.status == "final"]
            (part,) = [e for e in parts if e.state == "moving"]
            assert part.start_time - 1e-6 <= at <= part.end_time + 1e-6
            assert part.start_time <= part.active_start <= part.active_end <= part.end_time
            assert part.active_joints
            assert all(e.active_start is None for e in parts if e.state == "resting")


def test_a_sensor_that_wakes_up_is_no_movement_for_long():
    times = np.arange(300) / FPS
    poses = raising(times, [], 0.003)
    poses[:90] = poses[0]  # it repeats its first pose, then its noise begins
    found = activity(streamed(poses, times))
    assert [e.state for e in found] in ([], ["moving", "resting"])


def test_a_stream_that_repeats_poses_for_a_moment_goes_on_as_before():
    poses, times, _ = four_holds(0.003)
    poses[140:150] = poses[140]  # within a rest
    assert [e.state for e in activity(streamed(poses, times))] == ["moving", "resting"] * 8
