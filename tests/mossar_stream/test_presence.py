"""Whoever is not there does not count, and where somebody stands does not matter."""

import numpy as np
import pytest

from mossar_stream import KeyFrameEvent, Performers, Segmenter, Settings, Skeleton, segment_recording
from mossar_stream.events import to_json
from mossar_stream.frames import Frames

FPS = 60.0
JOINTS = 9
MEASURES = {
    "evidence": Settings(),
    "likelihood": Settings(level="posture"),
    "distances": Settings(level="cluster"),
    "paper": Settings.build("paper"),
    "sum": Settings.build("paper", {"kernel_form": "sum"}),
    "damped": Settings(level="posture", similarity="path_kernel", kernel_form="damped", location="none"),
}
# The filtered pose of evidence, and the weight of the pairs that are there, are of single precision.
WITHIN = {"evidence": 1e-6, "distances": 1e-7}
SHIFTS = ((10_000.0, -48.0, 32.0), (7_777.3, -9_999.9, 3.2), (5.0, 0.0, 0.0))  # m


def skeleton(joints, root=0):
    names = tuple(f"j{i}" for i in range(joints))
    return Skeleton(names, (-1,) + (0,) * (joints - 1)) if root == 0 else Skeleton(names, root=-1)


def person(seed=0, frames=700):
    """Return (frames, JOINTS, 3) m of somebody whose joints move from place to place while the body wanders."""
    rng = np.random.default_rng(seed)
    positions = np.zeros((frames, JOINTS, 3))
    for j in range(1, JOINTS):
        for axis in range(3):
            at, here = 0, rng.uniform(-0.5, 0.5)
            while at < frames:
                moving, resting = rng.integers(20, 60), rng.integers(0, 20)
                there = here + rng.normal(0, 0.15)
                way = here + (there - here) * (1 - np.cos(np.linspace(0, np.pi, moving))) / 2
                way = np.append(way, np.full(resting, there))[: frames - at]
                positions[at : at + len(way), j, axis] = way
                at, here = at + len(way), there
    positions += np.cumsum(rng.normal(0, 0.004, (frames, 1, 3)), axis=0)
    return positions.astype(np.float32).astype(float)


def with_losses(positions, seed=5):
    """Return a copy in which joints come late, go for long and for short."""
    rng = np.random.default_rng(seed)
    holes = positions.copy()
    holes[rng.random(holes.shape[:2]) < 0.03] = np.nan
    holes[300:420, 3] = np.nan
    holes[:200, 5] = np.nan
    return holes


def strengths(positions, settings, root=0):
    found = segment_recording(positions, FPS, skeleton(positions.shape[1], root), settings)
    return {key.frame: key.strength for key in found.key_frames}


def final(events):
    return [(e.frame, e.take) for e in events if isinstance(e, KeyFrameEvent) and e.status == "final"]


@pytest.mark.parametrize("root", [0, -1])
@pytest.mark.parametrize("name", MEASURES)
def test_joints_that_are_never_seen_change_nothing(name, root):
    seen = person()
    more = np.full((len(seen), JOINTS + 4, 3), np.nan)
    more[:, :JOINTS] = seen
    with_them, without = strengths(more, MEASURES[name], root), strengths(seen, MEASURES[name], root)
    assert list(with_them) == list(without)
    assert len(without) > 5
    within = WITHIN.get(name, 1e-9)
    np.testing.assert_allclose([*with_them.values()], [*without.values()], rtol=within)


@pytest.mark.parametrize("name", MEASURES)
def test_joints_that_are_never_seen_stay_nowhere_as_the_body_walks_away(name):
    seen = person()
    more = np.full((len(seen), JOINTS + 4, 3), np.nan)
    more[:, :JOINTS] = seen
    walking = more + np.linspace(0, 40.0, len(seen))[:, None, None]
    assert strengths(walking, MEASURES[name]) == pytest.approx(strengths(more, MEASURES[name]), rel=2e-3)


@pytest.mark.parametrize("root", [0, -1])
@pytest.mark.parametrize("name", MEASURES)
def test_ten_kilometres_change_nothing_with_joints_missing_too(name, root):
    holes = with_losses(person())
    here = strengths(holes, MEASURES[name], root)
    for shift in SHIFTS:
        there = strengths(holes + np.array(shift), MEASURES[name], root)
        assert there == pytest.approx(here, rel=2e-3, abs=1e-4), shift
    # The places that are taken off are whole multiples of 16 m: so far, every bit is the same.
    assert strengths(holes + np.array([9_984.0, -4_800.0, 16.0]), MEASURES[name], root) == here


@pytest.mark.filterwarnings("ignore:no joint moves")
@pytest.mark.parametrize("name", ["evidence", "likelihood", "paper"])
def test_a_joint_that_arrives_changes_nothing_of_what_was_before(name):
    late = person()
    late[:400, 5] = np.nan
    before = strengths(np.delete(late, 5, 1)[:380], MEASURES[name])
    with_it = strengths(late[:380], MEASURES[name])
    assert with_it == pytest.approx(before)
    # Nor is its coming a movement: nobody moves here, and one joint comes.
    still = np.repeat(person()[:1], 300, axis=0)
    still[:150, 5] = np.nan
    assert not strengths(still, MEASURES[name])


@pytest.mark.parametrize("smoothing", ["none", "one_euro"])
@pytest.mark.parametrize("root", [0, -1])
@pytest.mark.parametrize("name", ["evidence", "likelihood", "paper"])
def test_a_joint_that_is_back_elsewhere_did_not_move_there(name, root, smoothing):
    noise = np.random.default_rng(4).normal(0, 0.002, (600, JOINTS, 3))
    still = np.repeat(person()[:1], 600, axis=0) + noise
    still[200:300, 5] = np.nan
    still[300:, 5] += [0.9, 0.0, 0.0]
    settings = MEASURES[name].replace(smoothing=smoothing)
    segmenter = Segmenter(skeleton(JOINTS, root), settings, fps=FPS)
    speeds = []
    for k in range(600):
        segmenter.push(still[k], k / FPS)
        speeds.append(segmenter.state.value * segmenter.state.scale)
    assert max(speeds[295:400]) < 1.5 * max(speeds[100:200])


def test_a_root_that_is_seen_late_is_where_the_take_begins():
    late = person()
    late[:100, 0] = np.nan
    found = strengths(late, Settings())
    from_there = strengths(late[100:], Settings())
    later = [frame for frame in found if frame > 160]
    assert [frame for frame in later if frame - 100 in from_there] == later
    # Key frames are told of where poses show them, earlier.
    assert not [frame for frame in found if frame < 90]


@pytest.mark.parametrize("name", ["evidence", "likelihood", "paper"])
@pytest.mark.parametrize("root", [0, -1])
def test_nothing_of_a_missing_joint_is_left_for_the_next_take(name, root):
    first, second = person(1), person(2)
    first[:, 4] += [5.0, -3.0, 8.0]
    second[:, 4] = np.nan
    used = Segmenter(
        skeleton(JOINTS, root),
        MEASURES[name].replace(range="fixed", range_max=5.0, noise_margin=0.0),
        fps=FPS,
    )
    fresh = Segmenter(skeleton(JOINTS, root), used.settings, fps=FPS)
    used.push(first)
    used.end_take()
    again = used.push(second) + used.end_take()
    once = fresh.push(second) + fresh.end_take()
    assert [to_json(e).replace(b"/1/", b"/0/").replace(b'"take":1', b'"take":0') for e in again] == [
        to_json(e) for e in once
    ]


@pytest.mark.parametrize("name", ["evidence", "likelihood", "paper"])
def test_far_away_too_chunks_snapshots_and_pools_change_nothing(name):
    settings = MEASURES[name]
    positions = with_losses(person()) + np.array([9_000.0, 3.0, -4_321.0])
    times = np.arange(len(positions)) / FPS
    times[500:] += 10.0  # a take ends here, and the next one begins elsewhere
    positions[500:] -= [8_000.0, 0.0, 0.0]
    one = Segmenter(skeleton(JOINTS), settings)
    whole = one.push(positions, times) + one.end_take()
    by_one = Segmenter(skeleton(JOINTS), settings)
    events = []
    for i, (frame, time) in enumerate(zip(positions, times.tolist(), strict=True)):
        if i % 200 == 77:
            by_one = Segmenter.restore(by_one.snapshot())
        events += by_one.push(frame, time)
    assert events + by_one.end_take() == whole
    pool = Performers(settings)
    pool.announce("p1", skeleton(JOINTS))
    pool.announce("p2", skeleton(JOINTS))
    events = []
    for at in range(0, len(positions), 50):  # 500 is a border
        part = slice(at, at + 50)
        events += pool.push_many(["p1", "p2"], np.stack([positions[part]] * 2), times[part])
    events += pool.end_takes()
    assert [e for e in events if e.performer == "p1"] == whole
    frames = Performers(settings)
    frames.announce("p1", skeleton(JOINTS))
    assert frames.push(Frames(positions, times)) + frames.end_takes() == whole


def test_single_precision_is_as_good_near_the_origin():
    positions = person()
    times = np.arange(len(positions)) / FPS
    events = []
    for kind in (np.float32, np.float64):
        segmenter = Segmenter(skeleton(JOINTS), Settings())
        found = []
        for frame, time in zip(positions.astype(kind), times.tolist(), strict=True):
            found += segmenter.push(frame, time)
        events.append(found + segmenter.end_take())
    assert events[0] == events[1]
    assert final(events[0])


@pytest.mark.parametrize(
    "settings", [Settings(), Settings(level="posture"), Settings(level="posture", max_gap=0.1)]
)
@pytest.mark.parametrize("fps", [4.0, 10.0, 20.0, 25.0, 50.0, 60.0])
def test_the_origin_of_time_does_not_matter(settings, fps):
    """These rates have frames exactly as far apart as the times that things are compared with."""
    positions = person(0, 400) + np.random.default_rng(0).normal(0, 0.002, (400, JOINTS, 3))
    found = []
    for origin in (0.0, 0.1, 1000.0, 1e6, 1.7e9):
        segmenter = Segmenter(skeleton(JOINTS), settings)
        times = origin + np.arange(len(positions)) / fps
        found.append(final(segmenter.push(positions, times) + segmenter.end_take()))
    assert all(other == found[0] for other in found)


def test_a_source_of_three_frames_a_second_has_no_gaps():
    positions = person(0, 2000)[::20]
    segmenter = Segmenter(skeleton(JOINTS), Settings(level="posture"), fps=3.0)
    events = segmenter.push(positions) + segmenter.end_take()
    assert any(isinstance(event, KeyFrameEvent) for event in events)
    assert segmenter.stats["gaps"] == 0


def alone(seed=3, before=200, empty=120, after=200):
    """Return (n, JOINTS, 3) m of a person who goes away and comes back, and (n,) s."""
    positions = person(seed, before + empty + after)
    positions[before : before + empty] = np.nan
    return positions, np.arange(len(positions)) / FPS


def streams(events):
    return [
        (e.event, e.take, e.reason)
        for e in events
        if getattr(e, "type", "") == "stream" or hasattr(e, "reason")
    ]


@pytest.mark.parametrize("limbs", [False, True])
def test_an_empty_room_gives_not_a_single_event(limbs):
    names = Skeleton(("hip", "left_hand", "right_hand"), (-1, 0, 0))
    segmenter = Segmenter(names, Settings(limbs="left=hip,left_hand" if limbs else False), fps=FPS)
    nobody = np.full((400, 3, 3), np.nan)
    events = [event for k in range(400) for event in segmenter.push(nobody[k], k / FPS)]
    assert events + segmenter.end_take() == []
    assert segmenter.stats["unseen"] == 400


@pytest.mark.parametrize("sizes", [1, 7, 64, 1000])
def test_a_take_ends_where_nobody_was_seen_for_a_pause_and_the_next_begins_with_a_joint(sizes):
    positions, times = alone()
    segmenter = Segmenter(skeleton(JOINTS), fps=FPS)
    events = []
    for k in range(0, len(times), sizes):
        events += segmenter.push(positions[k : k + sizes], times[k : k + sizes])
    events += segmenter.end_take("done")
    assert streams(events) == [
        ("started", 0, ""),
        ("ended", 0, "nobody seen"),
        ("started", 1, ""),
        ("ended", 1, "done"),
    ]
    whole = Segmenter(skeleton(JOINTS), fps=FPS)
    once = whole.push(positions, times) + whole.end_take("done")
    assert [to_json(e) for e in events] == [to_json(e) for e in once]
    cut = next(k for k, e in enumerate(events) if getattr(e, "reason", "") == "nobody seen")
    ends = [e.end_time for e in events[:cut] if hasattr(e, "end_time") and e.status == "final"]
    pause = segmenter.settings.max_pause
    assert max(ends) <= times[199] + pause + 2 / FPS


@pytest.mark.parametrize("empty", [30, 59])
def test_a_pause_of_at_most_max_pause_goes_on(empty):
    positions, times = alone(empty=empty)
    segmenter = Segmenter(skeleton(JOINTS), fps=FPS)
    events = segmenter.push(positions, times) + segmenter.end_take("done")
    assert streams(events) == [("started", 0, ""), ("ended", 0, "done")]


def test_snapshots_of_an_empty_room_go_on_there():
    positions, times = alone()
    one = Segmenter(skeleton(JOINTS), fps=FPS)
    events = one.push(positions, times) + one.end_take()
    for cut in (230, 275, 300):
        first = Segmenter(skeleton(JOINTS), fps=FPS)
        told = first.push(positions[:cut], times[:cut])
        second = Segmenter.restore(first.snapshot())
        told += second.push(positions[cut:], times[cut:]) + second.end_take()
        assert [to_json(e) for e in told] == [to_json(e) for e in events], cut


def test_limbs_end_with_a_body_that_nobody_sees():
    names = Skeleton(("hip", "left_hand", "right_hand"), (-1, 0, 0))
    positions, times = alone(5)
    limbs = "left=hip,left_hand;right=hip,right_hand"
    found = []
    for sizes in (1, 50, 1000):
        segmenter = Segmenter(names, Settings(limbs=limbs), fps=FPS)
        events = []
        for k in range(0, len(times), sizes):
            events += segmenter.push(positions[k : k + sizes, :3], times[k : k + sizes])
        events += segmenter.end_take()
        found.append([to_json(e) for e in events])
        ended = next(k for k, e in enumerate(events) if getattr(e, "reason", "") == "nobody seen")
        assert all(e.take == 0 for e in events[:ended])
        assert all(e.take == 1 for e in events[ended + 1 :])
        assert {e.channel for e in events[ended:] if hasattr(e, "channel")} >= {"body"}
    assert found[0] == found[1] == found[2]


def test_fingers_and_faces_are_not_among_the_active_joints():
    face = ("nose", "left_eye", "right_ear", "mouth_left")
    fingers = ("left_pinky", "left_index", "left_thumb")
    others = ("left_hip", "left_shoulder", "left_elbow", "left_wrist", "left_knee", "left_ankle", "left_heel",
              "left_foot_index")  # fmt: skip
    names = (*others, *face, *fingers)
    person_of_many = Skeleton(names, (-1,) + (0,) * (len(names) - 1))
    times = np.arange(240) / FPS
    positions = np.random.default_rng(2).normal(size=(1, len(names), 3)).repeat(240, 0)
    arm = [names.index(name) for name in ("left_wrist", *face, *fingers)]
    positions[60:180, arm, 1] += 0.5 * np.sin(np.arange(120) / 12)[:, None] * np.linspace(1, 3, len(arm))
    segmenter = Segmenter(person_of_many, fps=FPS)
    events = segmenter.push(positions, times) + segmenter.end_take()
    told = [
        event.active_joints
        for event in events
        if getattr(event, "state", "") == "moving" and hasattr(event, "active_joints")
    ]
    assert any(told)
    assert all(joints[0] == "left_wrist" for joints in told if joints)
    assert not {*face, *fingers} & {joint for joints in told for joint in joints}
    glove = Skeleton(("left_wrist", *fingers), (-1, 0, 0, 0))
    lone = Segmenter(glove, fps=FPS)
    events = lone.push(positions[:, [names.index(n) for n in glove.names]], times) + lone.end_take()
    assert any("left_thumb" in getattr(event, "active_joints", ()) for event in events)
