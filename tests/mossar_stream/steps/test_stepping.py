"""Steps: found where they are, live as offline, in any chunks, after snapshots, and not where a performer only wiggles."""

import itertools

import msgspec
import numpy as np
import pytest

from checks.gaits import FEET, GAITS, SKELETON, performed, wiggling
from mossar_stream import (
    FrameError,
    Segmenter,
    Settings,
    SettingsError,
    Skeleton,
    SnapshotError,
    StepEvent,
    gait_of,
    segment_recording,
    step_table,
)
from mossar_stream.core.kernels import RECORDS
from mossar_stream.steps.feet import feet_of

STEPS = Settings(steps=True, feet=FEET, level="posture")


def steps_of(events):
    return [event for event in events if isinstance(event, StepEvent)]


def offline(positions, times, settings=STEPS):
    return segment_recording(positions, None, SKELETON, settings, times=times).steps


@pytest.mark.parametrize("name", sorted(GAITS))
@pytest.mark.parametrize(("fps", "noise"), [(100.0, 0.001), (30.0, 0.005)])
def test_every_kind_of_walk_is_found_step_by_step(name, fps, noise):
    positions, times, truth = performed(GAITS[name], 15.0, fps, noise, seed=7)
    found = sorted(offline(positions, times), key=lambda event: event.time)
    assert len(found) == len(truth) > 10
    tolerance = {"strike": 0.05, "off": 0.07} if fps > 45 else {"strike": 0.1, "off": 0.1}
    for side in ("left", "right"):
        for status, limit in tolerance.items():
            moments = [moment for moment, own, what in truth if (own, what) == (side, status)]
            own = [event.time for event in found if (event.side, event.status) == (side, status)]
            assert own == pytest.approx(moments, abs=limit)


@pytest.mark.parametrize("axes", [(0, 1, 2), (1, 2, 0), (2, 0, 1)])
def test_any_axis_may_point_upwards(axes):
    positions, times, truth = performed(GAITS["on the spot"], 12.0, 60.0, 0.001)
    assert len(offline(np.ascontiguousarray(positions[:, :, axes]), times)) == len(truth)


def test_a_performer_who_wiggles_makes_no_steps():
    positions = wiggling(120.0, 30.0, 0.01)
    assert offline(positions, np.arange(len(positions)) / 30) == []


def test_a_foot_that_hangs_in_the_air_has_not_come_down():
    positions, _, _ = performed(GAITS["walking"], 14.0, 60.0)
    more = np.zeros(((3 * 60), *positions.shape[1:]), np.float32) + positions[-1]
    whole = np.concatenate([positions, more])
    times = np.arange(len(whole)) / 60
    kick = np.clip((times - 14.2) / 0.4, 0, 1) - np.clip((times - 15.6) / 0.4, 0, 1)
    whole[:, 2:5, 1] += (0.8 * kick**2 * (3 - 2 * kick))[:, None]
    found = [event for event in offline(whole, times) if event.time > 14]
    assert [event.status for event in found] == ["off", "strike"]
    assert found[1].time == pytest.approx(16.0, abs=0.07)


@pytest.mark.parametrize("size", [1, 7, 64, 10_000])
def test_chunks_do_not_matter_and_a_stream_says_what_a_recording_says(size):
    positions, times, _ = performed(GAITS["walking"], 8.0, 60.0, 0.003)
    segmenter = Segmenter(SKELETON, Settings(steps=True, feet=FEET))
    events = [
        event
        for begin in range(0, len(times), size)
        for event in segmenter.push(positions[begin : begin + size], times[begin : begin + size])
    ]
    whole = Segmenter(SKELETON, Settings(steps=True, feet=FEET)).push(positions, times)
    assert [msgspec.json.encode(e) for e in events] == [msgspec.json.encode(e) for e in whole]
    times_found = [event.time for event in steps_of(events)]
    assert times_found == pytest.approx([event.time for event in offline(positions, times)], abs=1e-6)


def test_one_frame_at_a_time_gives_the_same_events():
    positions, times, _ = performed(GAITS["fast"], 6.0, 60.0, 0.003)
    for extra in ({}, {"limbs": True}, {"repetitions": True, "phase": True}):
        settings = Settings(steps=True, feet=FEET, **extra)
        segmenter = Segmenter(SKELETON, settings)
        events = [e for p, t in zip(positions, times.tolist(), strict=True) for e in segmenter.push(p, t)]
        whole = Segmenter(SKELETON, settings).push(positions, times)
        assert [msgspec.json.encode(e) for e in events] == [msgspec.json.encode(e) for e in whole]
        assert steps_of(events)


def test_snapshots_go_on_exactly_where_they_were():
    positions, times, _ = performed(GAITS["walking"], 6.0, 60.0, 0.003)
    segmenter = Segmenter(SKELETON, Settings(steps=True, feet=FEET))
    whole = Segmenter(SKELETON, Settings(steps=True, feet=FEET)).push(positions, times)
    events = []
    for begin in range(0, len(times), 13):
        segmenter = Segmenter.restore(segmenter.snapshot())
        events += segmenter.push(positions[begin : begin + 13], times[begin : begin + 13])
    assert [msgspec.json.encode(e) for e in events] == [msgspec.json.encode(e) for e in whole]


def test_a_state_of_other_feet_is_refused():
    segmenter = Segmenter(SKELETON, Settings(steps=True, feet=FEET))
    stepping = segmenter._followers.stepping
    known = bytearray(stepping.to_bytes())
    with pytest.raises(SnapshotError, match="another size"):
        stepping.go_on_from(bytes(known[:-1]))
    known[RECORDS["Steps"].fields["feet"][1]] ^= 1
    with pytest.raises(SnapshotError, match="other feet"):
        stepping.go_on_from(bytes(known))


def test_ids_count_the_events_of_a_take():
    positions, times, truth = performed(GAITS["walking"], 6.0, 60.0)
    segmenter = Segmenter(SKELETON, Settings(steps=True, feet=FEET), performer="ann")
    first = steps_of(segmenter.push(positions, times))
    second = steps_of(segmenter.push(positions, times + 100))
    assert [event.id for event in first] == [f"ann/step/0/{n + 1}" for n in range(len(truth))]
    assert [event.id for event in second] == [f"ann/step/1/{n + 1}" for n in range(len(truth))]
    assert [event.time - 100 for event in second] == pytest.approx([event.time for event in first])


@pytest.mark.parametrize("is_restored", [False, True])
def test_ids_go_on_when_steps_are_switched_off_and_on_in_a_take(is_restored):
    positions, times, _ = performed(GAITS["walking"], 12.0, 60.0)
    segmenter, events = Segmenter(SKELETON, STEPS), []
    for start in range(0, len(times), 120):
        events += segmenter.push(positions[start : start + 120], times[start : start + 120])
        events += segmenter.change(steps=False)
        if is_restored:
            segmenter = Segmenter.restore(segmenter.snapshot())
        events += segmenter.change(steps=True)
    numbers = [int(event.id.rpartition("/")[2]) for event in steps_of(events)]
    assert numbers == list(range(1, len(numbers) + 1))
    assert len(numbers) > 3


def test_joints_that_are_missing_for_a_moment_cost_no_steps():
    positions, times, truth = performed(GAITS["walking"], 12.0, 60.0)
    random = np.random.default_rng(1)
    positions[random.random(positions.shape[:2]) < 0.1] = np.nan
    assert len(offline(positions, times)) == len(truth)


def test_steps_far_from_the_origin_are_where_they_are():
    positions, times, truth = performed(GAITS["walking"], 6.0, 60.0)
    far = positions.astype(np.float64) + np.array([5000.0, 0, -3000.0])
    near, found = offline(positions, times), offline(far, times)
    assert len(found) == len(truth)
    for one, other in zip(near, found, strict=True):
        assert other.position == pytest.approx(np.add(one.position, [5000, 0, -3000]), abs=1e-2)


def test_settings_change_in_mid_take():
    positions, times, _ = performed(GAITS["walking"], 6.0, 60.0)
    segmenter = Segmenter(SKELETON, Settings(feet=FEET))
    assert steps_of(segmenter.push(positions[:180], times[:180])) == []
    segmenter.change(steps=True)
    assert steps_of(segmenter.push(positions[180:], times[180:]))


@pytest.mark.parametrize(
    ("names", "left"),
    [
        (("LANK", "LHEE", "LTOE", "RANK", "RHEE", "RTOE"), (0, 1, 2)),
        (("ann:LANK", "ann:LTOE", "ann:RANK", "ann:RTOE"), (0, 1)),
        (("LLM", "LCAL", "LMT1", "LMT5", "RLM", "RCAL", "RMT1", "RMT5"), (0, 2, 3, 1)),
        (("LCAL", "LMT1", "LMT2", "RCAL", "RMT1", "RMT2"), (0, 1, 2)),
        (("L.Heel", "L.Midfoot.Sup", "L.Toe.Tip", "R.Heel", "R.Midfoot.Sup", "R.Toe.Tip"), (0, 2)),
        (
            ("left_ankle", "left_heel", "left_foot_index", "right_ankle", "right_heel", "right_foot_index"),
            (0, 1, 2),
        ),
        (("left_ankle", "right_ankle"), (0,)),
        (("LeftFoot", "LeftToes", "RightFoot", "RightToes"), (0, 1)),
        (("AnkleLeft", "FootLeft", "AnkleRight", "FootRight"), (0, 1)),
        (
            ("LAnkle", "LBigToe", "LSmallToe", "LHeel", "RAnkle", "RBigToe", "RSmallToe", "RHeel"),
            (0, 3, 1, 2),
        ),
    ],
)
def test_feet_are_known_by_the_names_of_many_programs(names, left):
    found = feet_of(Skeleton(names, (-1,) * len(names), -1))
    assert found["left"] == left
    assert len(found["right"]) == len(left)


def test_a_skeleton_without_feet_is_refused_and_so_are_wrong_names():
    pair = Skeleton(("hip", "hand"), (-1, 0))
    with pytest.raises(FrameError, match="--feet"):
        Segmenter(pair, Settings(steps=True))
    with pytest.raises(FrameError, match="no joint called 'toe'"):
        Segmenter(pair, Settings(steps=True, feet="left=hip right=toe"))
    for feet in ("left=a", "left=a left=b", "both=a", "left= right=b", "left=a,b,c,d,e right=f"):
        with pytest.raises(SettingsError, match="feet"):
            Settings(feet=feet)
    for wrong in ({"step_sensitivity": 0}, {"up": "w"}, {"steps": 1.5}, {"feet": 3}):
        with pytest.raises(SettingsError):
            Settings(**wrong)


def test_the_table_of_steps_says_what_was_walked():
    gait = GAITS["walking"]
    positions, times, truth = performed(gait, 20.0, 100.0)
    steps = offline(positions, times)
    table, whole = step_table(steps), gait_of(steps)
    assert len(table) == whole.steps == len(truth) / 2
    assert whole.cadence == pytest.approx(120 / gait.cycle, rel=0.03)
    left = sorted((moment, what) for moment, side, what in truth if side == "left")
    swings = [b - a for (a, what), (b, _) in itertools.pairwise(left) if what == "off"]
    assert whole.swing["left"] == pytest.approx(np.median(swings), abs=0.04)
    assert whole.stance["left"] + whole.swing["left"] == pytest.approx(gait.cycle, abs=0.02)
    assert table[4].step_length == pytest.approx(np.hypot(gait.stride / 2, 0.22), abs=0.05)
    assert whole.asymmetry["swing"] < 10
    assert table[-1].end is None
    frame = segment_recording(positions, None, SKELETON, STEPS, times=times)
    pytest.importorskip("pandas")
    assert list(frame.steps_dataframe()["side"][:2]) == [table[0].side, table[1].side]


def test_no_steps_make_an_empty_table():
    assert step_table([]) == []
    assert gait_of([]).cadence is None
