"""Mirror images: the other side is followed as the side that was shown, also of real people, and whatever axis is up."""

from pathlib import Path

import numpy as np
import pytest

from checks.following import FPS as RATE
from checks.following import NAMES, SKELETON, person_of
from mossar_stream import FollowEvent, Moves, MovesError, Segmenter, Settings
from mossar_stream.moves.mirroring import mirrored_joints

from .test_following import FPS, PERSON, events_of, followed, people, performed

PUNCHES = ["punch_left", "kick_right", "punch_left", "punch_right"]
PEOPLE = Path(__file__).parents[4] / "shared" / "data" / "quality" / "ui_prmd"


def image_of(positions, skeleton):
    """Return what a mirror in the plane of y and z shows of people."""
    return positions[:, mirrored_joints(skeleton)] * np.array([-1, 1, 1], np.float32)


def of_other_side(limb):
    return limb.replace("left", "LEFT").replace("right", "left").replace("LEFT", "right")


def done_in(repetitions, name, example, *, follow, up="auto", turn=(0, 1, 2)):
    moves = Moves(SKELETON)
    moves.add(name, example[:, :, turn], RATE)
    moves.set_rule(name, mirrored=True)
    segmenter = Segmenter(SKELETON, Settings(up=up), fps=RATE, moves=moves, follow=follow)
    events = [*segmenter.push(np.concatenate(repetitions)[:, :, turn]), *segmenter.end_take()]
    return [event for event in events if isinstance(event, FollowEvent) and event.status == "done"]


def test_the_other_side_is_followed_under_its_name():
    moves = Moves(PERSON)
    moves.add("punch_left", performed("punch_left"), FPS)
    moves.set_rule("punch_left", mirrored=True)
    positions, times, _ = people.session(PUNCHES)
    segmenter = Segmenter(PERSON, moves=moves, follow=True)
    assert list(segmenter.following) == ["punch_left", "punch_right"]
    done = followed(events_of(segmenter, positions, times, 16), "done")
    wanted = [name for name in PUNCHES if name in moves.reported]
    assert [event.name for event in done] == wanted
    assert all(event.deviation < 5 for event in done)
    only = Segmenter(PERSON, moves=moves, follow=("punch_right",))
    assert [e.name for e in followed(events_of(only, positions, times, 16), "done")] == ["punch_right"]


def test_without_the_rule_there_is_no_other_side():
    moves = Moves(PERSON)
    moves.add("punch_left", performed("punch_left"), FPS)
    with pytest.raises(MovesError, match="no move called 'punch_right'"):
        Segmenter(PERSON, moves=moves, follow=("punch_right",))


@pytest.fixture(scope="module")
def person():
    files = sorted(PEOPLE.glob("s*.npz"))
    if not files:
        pytest.skip("needs ../shared/data/quality/ui_prmd")
    return person_of(files[3])


@pytest.mark.parametrize(("up", "turn"), [("auto", (0, 1, 2)), ("z", (2, 0, 1)), ("x", (1, 2, 0))])
@pytest.mark.parametrize("exercise", ["m02", "m07", "m10"])
def test_people_in_a_mirror_are_counted_and_judged_alike(person, exercise, up, turn):
    right = person[exercise]["right"]
    example, rest = right[0], right[1:]
    other = [image_of(one, SKELETON) for one in rest]
    shown = done_in(rest, "lift_left", example, follow=("lift_left",), up=up, turn=turn)
    seen = done_in(other, "lift_left", example, follow=("lift_right",), up=up, turn=turn)
    assert len(shown) == len(seen) == 9
    for one, same in zip(shown, seen, strict=True):
        assert abs(one.time - same.time) < 0.04
        assert same.deviation == pytest.approx(one.deviation, abs=0.1)
        assert same.joint in NAMES.split()
        for limb, angle in one.limbs.items():
            assert same.limbs[of_other_side(limb)] == pytest.approx(angle, abs=0.1)
            assert same.range.get(of_other_side(limb), 1) == pytest.approx(one.range.get(limb, 1), abs=0.02)


def test_a_move_without_a_side_is_judged_by_the_side_that_is_made(person):
    right = person["m10"]["right"]
    example, rest = right[0], right[1:]
    both = [*rest[:4], *(image_of(one, SKELETON) for one in rest[4:])]
    alone = done_in(rest, "lift", example, follow=("lift",))
    seen = done_in(both, "lift", example, follow=("lift",))
    assert [event.count for event in seen] == list(range(1, 10))
    apart = np.abs([one.deviation - same.deviation for one, same in zip(alone, seen, strict=True)])
    assert np.median(apart) < 0.2  # weights of bones are those of one side, and not of the difference of both
