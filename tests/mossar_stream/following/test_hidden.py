"""Hidden limbs: what a sensor does not see for a good part of a performance is not judged from where it was last."""

import msgspec
import numpy as np
import pytest

from mossar_stream import Event, Moves, Segmenter, to_json

from .test_following import (
    FPS,
    PERSON,
    STANDING,
    events_of,
    followed,
    lines_of,
    moves,
    performed,
)

__all__ = ["moves"]  # fixtures
LEFT_ARM, RIGHT_ARM, RIGHT_LEG = (3, 4, 5), (6, 7, 8), (12, 13, 14)
BEGIN, END = 45, 72  # frames of the punch


@pytest.fixture
def punch():
    still = np.repeat(STANDING[None], BEGIN, axis=0)
    return np.concatenate([still, performed("punch_left"), still, still]).astype(np.float32)


def events_while(moves, positions, size=16):
    times = np.arange(len(positions)) / FPS
    return events_of(Segmenter(PERSON, moves=moves, follow=("punch_left",)), positions, times, size)


def done_while(moves, positions):
    done = followed(events_while(moves, positions), "done")
    assert [event.count for event in done] == [1]
    return done[0]


def arm_held_sideways(positions, degrees=90.0):
    """Return the positions with the right arm where it is not in the example, and was last seen."""
    positions, angle = positions.copy(), np.radians(degrees)
    way = np.array([np.sin(angle), -np.cos(angle), 0.0], np.float32)
    for k, joint in enumerate(RIGHT_ARM[1:], start=1):
        positions[:, joint] = positions[:, RIGHT_ARM[0]] + 0.22 * k * way
    return positions


def test_a_limb_that_is_hidden_is_left_out_and_the_others_weigh_more(moves, punch):
    seen = done_while(moves, punch)
    strays = done_while(moves, arm_held_sideways(punch))
    assert strays.limb == "right_arm"
    assert strays.limbs["right_arm"] > 40
    hidden = arm_held_sideways(punch)
    hidden[BEGIN - 10 : END + 10, RIGHT_ARM] = np.nan
    event = done_while(moves, hidden)
    assert set(event.limbs) == set(seen.limbs) - {"right_arm"}
    assert event.limb != "right_arm"
    assert not event.joint.startswith("right_wrist")
    assert event.deviation < seen.deviation + 1 < strays.deviation
    assert event.score > strays.score
    for limb, angle in event.limbs.items():
        assert angle == pytest.approx(seen.limbs[limb], abs=0.3)


def test_a_limb_that_moves_has_no_range_while_it_is_hidden(moves, punch):
    assert set(done_while(moves, punch).range) == {"left_arm"}
    positions = punch.copy()
    positions[BEGIN + 11 : BEGIN + 22, LEFT_ARM] = np.nan  # the way there and back is partly seen
    for event in followed(events_while(moves, positions), "done"):
        assert event.range == {}
        assert "left_arm" not in event.limbs


def test_short_holes_hide_nothing(moves, punch):
    seen = done_while(moves, punch)
    positions = punch.copy()
    positions[BEGIN + 3 : END : 5] = np.nan  # whole frames
    positions[BEGIN + 4 : END : 5, RIGHT_ARM] = np.nan
    assert set(done_while(moves, positions).limbs) == set(seen.limbs)


def test_one_joint_of_a_limb_does_not_hide_the_limb(moves, punch):
    positions = arm_held_sideways(punch)
    positions[:, 6:8] = punch[:, 6:8]  # only the wrist strays
    strays = done_while(moves, positions)
    assert strays.joint == "right_wrist"
    positions[BEGIN - 10 : END + 10, 8] = np.nan
    event = done_while(moves, positions)
    assert event.limbs["right_arm"] < 3 < strays.limbs["right_arm"]
    assert event.joint != "right_wrist"


def test_a_limb_is_judged_by_the_part_that_was_seen(moves, punch):
    positions = punch.copy()
    positions[BEGIN : BEGIN + 9] = arm_held_sideways(punch, 35.0)[BEGIN : BEGIN + 9]
    whole = done_while(moves, positions)
    positions[BEGIN + 1 : BEGIN + 9, RIGHT_ARM] = np.nan
    part = done_while(moves, positions)
    assert part.limbs["right_arm"] < 0.8 * whole.limbs["right_arm"]


def test_the_limb_is_left_out_while_the_performance_goes_on(moves, punch):
    positions = punch.copy()
    positions[BEGIN - 10 : END + 10, RIGHT_LEG] = np.nan
    events = followed(events_while(moves, positions), "begun", "progress")
    assert events
    assert all("right_leg" not in event.limbs and "left_leg" in event.limbs for event in events)
    for event in events:
        assert msgspec.json.decode(to_json(event), type=Event) == event


def bowed(degrees):
    """Return (54, 15, 3): a body that bows forward and comes up again."""
    frames = np.repeat(STANDING[None], 54, axis=0)
    angles = np.radians(degrees) * np.sin(np.linspace(0, np.pi, 54)) ** 2
    above = [k for k in range(15) if k not in (0, 9, 10, 11, 12, 13, 14)]
    for frame, angle in zip(frames, angles, strict=True):
        y, z = (frame[above] - STANDING[0])[:, 1:].T
        frame[above, 1] = STANDING[0, 1] + np.cos(angle) * y - np.sin(angle) * z
        frame[above, 2] = np.sin(angle) * y + np.cos(angle) * z
    return frames


@pytest.mark.parametrize("hidden", [LEFT_ARM, (9, 10, 11)])
def test_the_facing_does_not_follow_a_shoulder_or_a_hip_that_is_hidden(hidden):
    moves = Moves(PERSON)
    moves.add("bow", bowed(55.0), FPS)
    still = np.repeat(STANDING[None], 45, axis=0)
    positions = np.concatenate([still, bowed(55.0), still]).astype(np.float32)
    times = np.arange(len(positions)) / FPS

    def limbs_of():
        events = events_of(Segmenter(PERSON, moves=moves, follow=True), positions, times, 16)
        return followed(events, "done")[0].limbs

    seen = limbs_of()
    positions[30:110, hidden] = np.nan
    others = limbs_of()
    assert len(others) == len(seen) - 1
    for limb, angle in others.items():
        assert angle == pytest.approx(seen[limb], abs=0.5)


def test_what_was_never_seen_does_not_keep_the_rest_from_being_followed(moves, punch):
    seen = done_while(moves, punch)
    at_a_desk = punch.copy()
    at_a_desk[:, [10, 11, 13, 14]] = np.nan  # knees and ankles
    event = done_while(moves, at_a_desk)
    assert set(event.limbs) == {"left_arm", "right_arm", "trunk"} & set(seen.limbs)
    assert event.limbs == {limb: seen.limbs[limb] for limb in event.limbs}
    assert event.deviation < 2


def test_a_limb_that_is_not_seen_after_a_gap_is_not_judged_from_before(moves, punch):
    gap = 30  # frames
    before = arm_held_sideways(punch)[: BEGIN - 20]
    after = punch[BEGIN - 20 :].copy()
    after[:, RIGHT_ARM] = np.nan
    times = np.concatenate([np.arange(len(before)), gap + len(before) + np.arange(len(after))]) / FPS
    segmenter = Segmenter(PERSON, moves=moves, follow=("punch_left",))
    done = followed(events_of(segmenter, np.concatenate([before, after]), times, 16), "done")
    assert [event.count for event in done] == [1]
    assert "right_arm" not in done[0].limbs
    assert done[0].deviation < 2


def test_chunks_and_snapshots_make_no_difference(moves, punch):
    positions = punch.copy()
    positions[BEGIN - 10 : BEGIN + 20, RIGHT_ARM] = np.nan
    times = np.arange(len(positions)) / FPS
    whole = lines_of(events_while(moves, positions, len(positions)))
    assert lines_of(events_while(moves, positions, 1)) == whole
    for cut in range(BEGIN - 8, END + 8, 3):
        first = Segmenter(PERSON, moves=moves, follow=("punch_left",))
        events = first.push(positions[:cut], times[:cut])
        second = Segmenter.restore(first.snapshot())
        events += [*second.push(positions[cut:], times[cut:]), *second.end_take()]
        assert lines_of(events) == whole


def test_a_performance_of_which_nothing_was_seen_is_not_done(moves, punch):
    positions = punch.copy()
    for first, last in ((-6, 8), (11, 21), (23, 29), (30, 37)):
        positions[BEGIN + first : BEGIN + last, 0] = np.nan  # the centre, relative to which all points lie
    events = followed(events_while(moves, positions))
    assert events
    assert not any(event.status == "done" for event in events)
    assert all((event.joint, event.limb) == ("", "body") for event in events if not event.limbs)
