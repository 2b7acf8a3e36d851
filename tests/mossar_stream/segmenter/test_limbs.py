"""Limbs have key frames of their own, and leave those of the body byte for byte as they are."""

import hashlib

import msgspec
import numpy as np
import pytest

from mossar_adapters.demo import performance
from mossar_adapters.joint_sets import BLAZEPOSE_33, CMU_31, HUMANOID, KINECT_20
from mossar_stream import (
    ActivityEvent,
    FrameError,
    KeyFrameEvent,
    Performers,
    RepetitionEvent,
    Segmenter,
    SegmentEvent,
    Settings,
    SettingsError,
    Skeleton,
    SnapshotError,
    StreamEvent,
    segment_recording,
    to_json,
)
from mossar_stream.core.row import region
from mossar_stream.core.snapshot import HEADER_BYTES, MAGIC, SNAPSHOT_VERSION
from mossar_stream.frames import Frames
from mossar_stream.moves.groups import MEAN, groups_of, leading_limb, positions_of
from mossar_stream.segmenter.limbs import settings_of_limbs

FPS = 30.0
FIVE = ["trunk", "left_arm", "right_arm", "left_leg", "right_leg"]
FORWARD = 2


def standing(skeleton, count):
    rng = np.random.default_rng(3)
    pose = rng.normal(0, 0.3, (len(skeleton), 3))
    frames = np.repeat(pose[None], count, axis=0)
    return (frames + rng.normal(0, 1e-5, frames.shape)).astype(np.float32)


def waving(skeleton=KINECT_20, joints=("ElbowLeft", "WristLeft", "HandLeft"), count=240):
    """Return positions and times: the whole body walks forward, and one arm swings in the middle of the take."""
    frames = standing(skeleton, count)
    frames[:, :, FORWARD] += np.linspace(0, 4, count)[:, None]
    swing = 0.4 * np.sin(np.linspace(0, 6 * np.pi, 120)) * np.sin(np.linspace(0, np.pi, 120))
    for joint in joints:
        frames[60:180, skeleton.index(joint), 0] += swing
    return frames, np.arange(count) / FPS


def events_of(settings, frames, times, size=64, skeleton=KINECT_20):
    segmenter = Segmenter(skeleton, settings)
    found = []
    for at in range(0, len(times), size):
        found += segmenter.push(frames[at : at + size], times[at : at + size])
    return found + segmenter.end_take("over")


def test_groups_are_known_by_the_joints_names():
    limbs = groups_of(KINECT_20, wanted=True)
    assert [limb.name for limb in limbs] == FIVE
    arm = next(limb for limb in limbs if limb.name == "left_arm")
    assert arm.skeleton.names == ("ShoulderLeft", "ElbowLeft", "WristLeft", "HandLeft")
    assert arm.skeleton.root == 0


@pytest.mark.parametrize("skeleton", [BLAZEPOSE_33, CMU_31, HUMANOID])
def test_limbs_of_other_sets_hang_on_shoulders_and_hips(skeleton):
    limbs = {limb.name: limb for limb in groups_of(skeleton, wanted=True)}
    assert list(limbs) == FIVE
    hangs_on = limbs["left_leg"].skeleton.names[0].lower()
    assert "hip" in hangs_on or "upperleg" in hangs_on


def test_groups_of_unknown_names_follow_the_hierarchy():
    snake = Skeleton(("base", "rod", "tip", "wheel", "rim"), (-1, 0, 1, 0, 3))
    limbs = groups_of(snake, wanted=True)
    assert {limb.name: limb.skeleton.names for limb in limbs} == {
        "rod": ("base", "rod", "tip"),
        "wheel": ("base", "wheel", "rim"),
    }


def test_groups_that_the_user_names():
    limbs = groups_of(KINECT_20, "left=ElbowLeft,HandLeft; head=Head")
    assert {limb.name: limb.skeleton.names for limb in limbs} == {
        "left": ("ShoulderLeft", "ElbowLeft", "HandLeft"),
        "head": ("ShoulderCenter", "Head"),
    }
    with pytest.raises(FrameError, match="limb x: no joint called 'Tail'"):
        groups_of(KINECT_20, "x=Tail")
    with pytest.raises(FrameError, match="hangs on nothing"):
        groups_of(KINECT_20, "x=HipCenter")


@pytest.mark.parametrize("text", ["x", "x=", "=a", "a b=c", "body=a", "a=b;a=c", "a=b,,c", "a/b=c", ";".join(
    f"l{i}=a" for i in range(17))])  # fmt: skip
def test_groups_that_are_none_are_refused(text):
    with pytest.raises(SettingsError, match="setting limbs"):
        Settings(limbs=text)


def test_settings_as_text():
    assert Settings.build(overrides={"limbs": "true"}).limbs is True
    assert Settings.build(overrides={"limbs": "false"}).limbs is False
    assert Settings.build(overrides={"limbs": "a=b"}).limbs == "a=b"


def test_the_bodys_events_stay_byte_for_byte():
    frames, times = waving()
    without = [to_json(event) for event in events_of(Settings(), frames, times)]
    found = events_of(Settings(limbs=True), frames, times)
    body = [
        to_json(
            msgspec.structs.replace(event, limb=None)
            if isinstance(event, SegmentEvent | ActivityEvent)
            else event
        )
        for event in found
        if getattr(event, "channel", "body") == "body"
    ]
    assert body == without
    assert not any(b"channel" in line or b"limb" in line.replace(b'"limb":null', b"") for line in without)
    woken = [event.limb for event in found if isinstance(event, ActivityEvent) and event.channel == "body"]
    assert "left_arm" in woken
    assert set(woken) <= set(FIVE)


def test_the_arm_that_swings_has_key_frames_and_walking_does_not_leak_into_it():
    frames, times = waving()
    found = events_of(Settings(limbs=True), frames, times)
    confirmed = [e for e in found if getattr(e, "status", "") == "confirmed"]
    left = [e for e in confirmed if e.channel == "left_arm"]
    assert len(left) > 6
    assert left[0].id.startswith("p1/left_arm/0/")
    assert not [e for e in confirmed if e.channel in ("right_arm", "left_leg", "right_leg", "trunk")]


def test_segments_of_the_body_say_which_limb_led():
    frames, times = waving()
    found = [e for e in events_of(Settings(limbs=True), frames, times) if isinstance(e, SegmentEvent)]
    moving = [e for e in found if e.channel == "body" and e.status == "final" and e.state == "moving"]
    assert moving
    assert {e.limb for e in moving} == {"left_arm"}
    assert leading_limb(["tail"], {"hand": "arm"}) is None


def gapped():
    frames, times = waving()
    times = times.copy()
    times[150:] += 5.0  # ends a take
    frames[40:60, 5] = np.nan
    return frames, times


@pytest.mark.parametrize("size", [1, 7, 240])
def test_it_does_not_matter_how_frames_are_cut(size):
    frames, times = gapped()
    once = [to_json(e) for e in events_of(Settings(limbs=True, repetitions=True), frames, times)]
    assert [
        to_json(e) for e in events_of(Settings(limbs=True, repetitions=True), frames, times, size)
    ] == once


def quicker(frames, times):
    """Return four frames in place of each, most of which come too soon to be taken in at level motion."""
    between = np.arange(4 * len(times) - 3) / 4
    whole = between.astype(int)
    later = np.minimum(whole + 1, len(times) - 1)
    share = (between - whole)[:, None, None].astype(np.float32)
    times = np.interp(between, np.arange(len(times)), times)
    times[[70, 301]] = times[69], np.nan
    return frames[whole] * (1 - share) + frames[later] * share, times


@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
@pytest.mark.parametrize("is_quick", [False, True])
@pytest.mark.parametrize("fps", [None, 5.0])  # at 5 the rows need more room than the rate promises
def test_the_events_of_a_limb_are_those_of_a_segmenter_of_its_joints_alone(fps, is_quick):
    frames, times = quicker(*gapped()) if is_quick else gapped()
    settings = Settings(limbs=True)
    segmenter = Segmenter(KINECT_20, settings, fps=fps)
    found = [e for i in range(len(times)) for e in segmenter.push(frames[i], float(times[i]))]
    found += segmenter.end_take("over")
    for limb in groups_of(KINECT_20, wanted=True):
        alone = Segmenter(limb.skeleton, settings_of_limbs(settings), fps=fps)
        own = positions_of(limb, frames)
        events = [e for i in range(len(times)) for e in alone.push(own[i], float(times[i]))]
        wanted = [
            msgspec.structs.replace(e, channel=limb.name, id=e.id.replace("p1/", f"p1/{limb.name}/"))
            for e in [*events, *alone.end_take("over")]
            if not isinstance(e, StreamEvent)
        ]
        assert [e for e in found if getattr(e, "channel", "body") == limb.name] == wanted
        assert wanted or limb.name != "left_arm"


@pytest.mark.parametrize("level", ["motion", "posture"])
def test_limbs_know_of_frames_that_come_too_soon_when_they_are_asked(level):
    frames, times = quicker(*waving())
    segmenter = Segmenter(KINECT_20, Settings(limbs=True, level=level))
    for k in range(250):
        segmenter.push(frames[k], float(times[k]))
        if k % 10 == 3:
            seen = {(state.frame, state.time) for state in segmenter.limb_states.values()}
            assert seen == {(segmenter.state.frame, segmenter.state.time)}
    segmenter.level = 0.1
    segmenter.push(frames[250], float(times[250]))
    last = {e.end_frame for e in segmenter.end_take() if isinstance(e, SegmentEvent) and e.status == "final"}
    assert max(last) == 250


@pytest.mark.parametrize("first", [0, 7])
def test_frames_with_numbers_give_the_same_however_they_are_cut(first):
    frames, times = gapped()
    numbers = first + np.arange(len(times)) + 5 * (np.arange(len(times)) >= 50)  # five were lost on the way
    parts = [(0, 50), (50, len(times))]
    singly = [(k, k + 1) for k in range(len(times))]
    found = []
    for cuts in (parts, singly):
        segmenter = Segmenter(KINECT_20, Settings(limbs=True))
        found.append([])
        for begin, end in cuts:
            found[-1] += segmenter.push(frames[begin:end], times[begin:end], first_frame=int(numbers[begin]))
        found[-1] += segmenter.end_take()
    assert found[0] == found[1]
    told = max(event.frame for event in found[0] if isinstance(event, KeyFrameEvent))
    assert told > 150 + 5 + first  # in the second take, which counts on


def test_what_is_said_of_a_take_stands_before_the_word_that_it_ended():
    frames, times = gapped()
    found = events_of(Settings(limbs=True), frames, times)
    for take in (0, 1):
        end = next(
            i
            for i, e in enumerate(found)
            if isinstance(e, StreamEvent) and (e.event, e.take) == ("ended", take)
        )
        assert all(event.take > take for event in found[end + 1 :])
    assert {e.take for e in found if getattr(e, "channel", "body") == "left_arm"} == {0, 1}


def test_a_snapshot_goes_on_exactly():
    frames, times = gapped()
    once = [to_json(e) for e in events_of(Settings(limbs=True), frames, times)]
    segmenter = Segmenter(KINECT_20, Settings(limbs=True))
    found = []
    for i in range(len(times)):
        found += segmenter.push(frames[i], float(times[i]))
        if i % 17 == 0:
            segmenter = Segmenter.restore(segmenter.snapshot())
    assert [to_json(e) for e in found + segmenter.end_take("over")] == once


def test_limbs_of_another_snapshot_are_refused():
    body, limbs = (
        Segmenter(KINECT_20, Settings(limbs=True)),
        Segmenter(KINECT_20, Settings(limbs="a=HandLeft")),
    )
    content, other = (msgspec.msgpack.decode(own.snapshot()[HEADER_BYTES:]) for own in (body, limbs))
    content["following"]["limbs"] = other["following"]["limbs"] * 5
    forged = msgspec.msgpack.encode(content)
    with pytest.raises(SnapshotError, match="not those of its settings"):
        Segmenter.restore(MAGIC + bytes([SNAPSHOT_VERSION]) + hashlib.sha256(forged).digest() + forged)


def test_the_level_moves_limbs_too():
    frames, times = waving()
    segmenter = Segmenter(KINECT_20, Settings(limbs=True, level=0.0))
    segmenter.push(frames[:150], times[:150])
    segmenter.level = 1e6
    merged = [
        e for e in segmenter.push(frames[150], float(times[150])) if getattr(e, "status", "") == "merged"
    ]
    assert {e.channel for e in merged} >= {"body", "left_arm"}


def test_limbs_can_be_had_while_a_take_goes_on():
    frames, times = waving()
    segmenter = Segmenter(KINECT_20)
    assert segmenter.limbs == ()
    segmenter.push(frames[:60], times[:60])
    assert segmenter.change(limbs=True) == []
    assert list(segmenter.limbs) == FIVE
    found = segmenter.push(frames[60:], times[60:])
    left = [
        e
        for e in found
        if getattr(e, "channel", "") == "left_arm" and getattr(e, "status", "") == "confirmed"
    ]
    assert left
    assert all(abs(e.frame / FPS - e.time) < 1e-6 for e in left)
    segmenter.change(limbs=False)
    assert segmenter.limbs == ()
    with pytest.raises(FrameError, match="no joint called"):
        segmenter.change(limbs="a=Tail")


@pytest.mark.parametrize("first", range(60, 66))
def test_a_snapshot_does_not_disturb_limbs_that_came_in_between_two_frames_of_the_body(first):
    frames, times = quicker(*waving())
    found = []
    for step in (0, 1):
        segmenter = Segmenter(KINECT_20)
        segmenter.push(frames[:first], times[:first])
        segmenter.change(limbs=True)
        found.append([])
        for k in range(first, 600):
            found[-1] += segmenter.push(frames[k], float(times[k]))
            if step:
                segmenter.snapshot()
        found[-1] += segmenter.end_take()
    assert found[0] == found[1]
    assert any(getattr(event, "channel", "") == "left_arm" for event in found[0])


def test_repetitions_of_a_limb_are_those_of_its_joints_alone_when_the_source_is_quick():
    frames, times = quicker(*waving())
    body = Segmenter(KINECT_20, Settings(limbs=True, repetitions=True, rate_limit=0.0), fps=5.0)
    arm = next(limb for limb in groups_of(KINECT_20, wanted=True) if limb.name == "left_arm")
    own = positions_of(arm, frames)
    own = (own - own[:, [arm.skeleton.root]]).reshape(len(frames), -1)
    for i in range(len(times)):
        body.push(frames[i], float(times[i]))
        row = body.core.channels[1 + body.limbs.index("left_arm")]
        # The pose that was counted last; at 120 Hz that is every fourth one.
        samples = region(row.memory, "samples").view(np.float32)
        latest = samples[-own.shape[1] :]
        assert any(np.array_equal(latest, own[k]) for k in range(max(0, i - 8), i + 1))


def test_repetitions_of_a_limb_are_the_same_when_its_row_grows_while_frames_come_in():
    frames = standing(KINECT_20, 300)
    frames[:, KINECT_20.index("HandLeft"), 0] += 0.3 - 0.3 * np.cos(2 * np.pi * np.arange(300) / 36)
    frames, times = quicker(frames, np.arange(300) / FPS)
    found = []
    for fps in (5.0, 120.0):  # of 5 Hz there is less room than these frames need
        body = Segmenter(KINECT_20, Settings(limbs=True, repetitions=True, rate_limit=0.0), fps=fps)
        events = [e for i in range(len(times)) for e in body.push(frames[i], float(times[i]))]
        events += body.end_take()
        found.append([to_json(e) for e in events if getattr(e, "channel", "") == "left_arm"])
        assert any(isinstance(e, RepetitionEvent) and e.channel == "left_arm" for e in events)
    assert found[0] == found[1]


def test_performers_share_pools_and_give_them_back():
    frames, times = waving()
    alone = [to_json(e) for e in events_of(Settings(limbs=True), frames, times)]
    pool = Performers(Settings(limbs=True))
    for name in ("p1", "p2"):
        pool.announce(name, KINECT_20)
    together = pool.push_many(["p1", "p2"], np.stack([frames, frames]), times)
    together += pool.end_takes("over")
    assert [to_json(e) for e in together if e.performer == "p1"] == alone
    pool.remove("p1")
    pool.announce("p3", KINECT_20)
    third = pool.push(Frames(frames, times, performer="p3")) + pool["p3"].end_take("over")
    assert [to_json(e).replace(b"p3", b"p1") for e in third] == alone
    with pytest.raises(FrameError, match="may take"):
        Performers(Settings(limbs=True), most_memory=100_000).announce("p", KINECT_20)
    with pytest.raises(FrameError, match="limb a"):
        Performers(Settings(limbs="a=Tail")).announce("p", KINECT_20)


@pytest.mark.parametrize("chosen", [("p",), ()])
def test_limbs_of_a_change_need_memory_like_those_of_a_newcomer(chosen):
    with_limbs = Performers(Settings(limbs=True))
    with_limbs.announce("p", KINECT_20)
    needed = with_limbs["p"].state_bytes
    pool = Performers(most_memory=needed - 1)
    pool.announce("p", KINECT_20)
    with pytest.raises(FrameError, match="may take"):
        pool.change(*chosen, limbs=True)
    assert pool["p"].limbs == ()
    assert pool.settings.limbs is False
    pool.change(*chosen, remerge_window=3)
    pool = Performers(most_memory=needed)
    pool.announce("p", KINECT_20)
    pool.change(*chosen, limbs=True)
    assert pool["p"].state_bytes == needed
    pool.change(*chosen, sig_threshold=0.02)
    pool.change(*chosen, limbs=False)
    assert pool["p"].state_bytes < needed


def test_a_recording_has_a_result_for_each_limb():
    frames, times = waving()
    result = segment_recording(frames, FPS, KINECT_20, Settings(limbs=True, range="file"), times=times)
    assert list(result.limbs) == FIVE
    assert len(result.limbs["left_arm"].key_frames) > 6
    assert result.limbs["left_arm"].at(count=3).segments
    assert "left_arm" in {part.limb for part in result.segments}
    plain = segment_recording(frames, FPS, KINECT_20, Settings(range="file"), times=times)
    assert plain.limbs == {}
    assert b"limb" not in msgspec.json.encode(plain.segments)


def test_joints_that_hang_on_nothing_move_against_the_mean_of_all():
    markers = Skeleton(("a", "b", "c", "center"), (), -1)
    assert [limb.joints[0] for limb in groups_of(markers, wanted=True)] == [MEAN]
    frames, times = waving(markers, ("a",))
    frames[100:110] = np.nan
    found = events_of(Settings(limbs=True), frames, times, skeleton=markers)
    assert [
        e for e in found if getattr(e, "channel", "") == "trunk" and getattr(e, "status", "") == "confirmed"
    ]
    assert all("center_" not in e.active_joints for e in found if isinstance(e, SegmentEvent))


@pytest.mark.parametrize("wrong", [np.nan, 2e6, np.inf])
def test_a_limb_that_hangs_on_the_mean_does_not_move_as_other_joints_are_missing_or_far_off(wrong):
    rng, markers = np.random.default_rng(1), Skeleton(tuple(f"m{k}" for k in range(10)), root=-1)
    frames = rng.normal(0, 0.3, (10, 3)) + rng.normal(0, 2e-4, (600, 10, 3))
    times = np.arange(600) / FPS
    swing = 0.4 * np.sin(np.linspace(0, 8 * np.pi, 300)) * np.sin(np.linspace(0, np.pi, 300))
    frames[150:450, 1, 0] += swing
    frames[150:450, 2, 0] += 1.3 * swing
    spoilt = frames.copy()
    spoilt[1::3, 9] = wrong
    spoilt[2::3, 8] = wrong
    settings = Settings(limbs="arm=m1,m2", level="posture")

    def live(given, size):
        found = events_of(settings, given.astype(np.float32), times, size, markers)
        return [
            e.time
            for e in found
            if isinstance(e, KeyFrameEvent) and e.status == "final" and e.channel == "arm"
        ]

    def recorded(given):
        result = segment_recording(given, FPS, markers, settings, times=times)
        return [key.time for key in result.limbs["arm"].at("posture").key_frames]

    clean = live(frames, 1)
    assert len(clean) >= 8
    assert live(spoilt, 1) == live(spoilt, 64)
    for one, other in ((clean, live(spoilt, 64)), (recorded(frames), recorded(spoilt))):
        assert len(one) == len(other)
        assert np.abs(np.subtract(one, other)).max() <= 0.1


@pytest.mark.parametrize("hidden", [("ElbowLeft", "WristLeft", "HandLeft"), ("ShoulderLeft",)])
@pytest.mark.parametrize("smoothing", ["none", "one_euro"])
@pytest.mark.parametrize("level", ["posture", "motion"])
def test_a_limb_that_is_not_seen_has_no_confirmed_key_frame(level, smoothing, hidden):
    frames, times = standing(KINECT_20, 900), np.arange(900) / FPS
    swing = 0.4 * np.sin(2 * np.pi * times / 1.7) * np.sin(2 * np.pi * times / 11.0)
    for joint in ("ElbowLeft", "WristLeft", "HandLeft"):
        frames[:, KINECT_20.index(joint), 0] += swing
    unseen = np.zeros(900, bool)
    for begin in range(100, 800, 83):  # at all phases of the swing, for 0.3 to 2 s
        unseen[begin : begin + 10 + begin % 50] = True
    lost = frames.copy()
    for joint in hidden:
        lost[unseen, KINECT_20.index(joint)] = np.nan
    settings = Settings(limbs=True, level=level, smoothing=smoothing)
    found = events_of(settings, lost, times, 1)
    assert [to_json(e) for e in found] == [to_json(e) for e in events_of(settings, lost, times, 64)]
    confirmed = [
        e.frame
        for e in found
        if isinstance(e, KeyFrameEvent) and e.channel == "left_arm" and e.status == "confirmed"
    ]
    assert len(confirmed) > 10
    assert not unseen[confirmed].any()


def test_a_limb_knows_what_its_body_repeats_live_and_in_recordings():
    frames, times = standing(KINECT_20, 900), np.arange(900) / FPS
    lift = np.clip(np.sin(2 * np.pi * np.maximum(times - 3.0, 0.0) / 2.5), 0.0, None) ** 2
    for joint, share in (("ElbowLeft", 0.3), ("WristLeft", 0.6), ("HandLeft", 0.7)):
        frames[:, KINECT_20.index(joint), 1] += share * lift
    # With keep, both ends of the rests between lifts are key frames.
    settings = Settings(limbs=True, rests="merge")
    told = {
        e.time
        for e in events_of(settings, frames, times, 7)
        if isinstance(e, KeyFrameEvent) and e.status == "final" and e.channel == "left_arm"
    }
    late = np.diff(sorted(time for time in told if time > 12.0))
    assert len(late) >= 5
    assert (np.abs(late - 2.5) <= 0.25).sum() >= 4  # one to a lift, and not one to each way
    assert late.min() > 2.0
    result = segment_recording(frames, FPS, KINECT_20, settings, times=times)
    recorded = {key.time for key in result.limbs["left_arm"].at("motion").key_frames}
    assert len(recorded & told) >= 0.8 * max(len(recorded), len(told))


@pytest.mark.parametrize(
    "parents", [(-1,), (-1, 0), (-1, -1), (-1, -1, -1), (-1, 0, 0), (-1, 0, 1), (-1, 0, -1)]
)
@pytest.mark.parametrize("root", [-1, 0, "last"])
def test_whatever_the_skeleton_limbs_leave_the_body_as_it_is(parents, root):
    skeleton = Skeleton(
        tuple(f"j{i}" for i in range(len(parents))), parents, len(parents) - 1 if root == "last" else root
    )
    frames, times = waving()
    frames = frames[:, 10 : 10 + len(parents)]
    of_body = [
        e for e in events_of(Settings(limbs=True), frames, times, 1, skeleton) if e_channel(e) == "body"
    ]
    plain = events_of(Settings(), frames, times, 1, skeleton)
    assert [
        to_json(msgspec.structs.replace(e, limb=None) if isinstance(e, SegmentEvent) else e) for e in of_body
    ] == [to_json(e) for e in plain]


def e_channel(event):
    return getattr(event, "channel", "body")


def test_a_skeleton_without_limbs_is_segmented_as_without_limbs():
    one, (frames, times) = Skeleton(("hand",), (-1,)), waving()
    frames = frames[:, KINECT_20.index("HandLeft")][:, None]
    segmenter = Segmenter(one, Settings(limbs=True, repetitions=True))
    assert segmenter.limbs == ()
    assert segmenter.limb_states == {}
    events = segmenter.push(frames[:99], times[:99])
    segmenter = Segmenter.restore(segmenter.snapshot())
    assert segmenter.limbs == ()
    events += segmenter.change(limbs=False) + segmenter.change(limbs=True)
    segmenter.level = 0.3
    events += segmenter.push(frames[99:], times[99:]) + segmenter.reset()
    said = [event.event for event in events if isinstance(event, StreamEvent)]
    assert said == ["started", "ended", "started", "ended", "reset"]
    pool = Performers(Settings(limbs=True))
    pool.announce("ann", one)
    assert pool.push(Frames(frames, times, performer="ann"))


def test_limbs_that_come_back_do_not_number_their_repetitions_anew():
    take = performance(fps=30.0, seconds=24.0, moves=["wave_left"] * 16)
    segmenter, events = Segmenter(take.skeleton, Settings(limbs=True, repetitions=True)), []
    for k in range(0, len(take.frames.times), 30):
        if k == 360:
            events += segmenter.change(limbs=False) + segmenter.change(limbs=True)
        events += segmenter.push(take.frames.positions[k : k + 30], take.frames.times[k : k + 30])
    told = [(e.id, e.rev) for e in events + segmenter.end_take() if isinstance(e, RepetitionEvent)]
    assert {e.channel for e in events if isinstance(e, RepetitionEvent)} > {"body"}
    assert len(told) == len(set(told)) > 10
