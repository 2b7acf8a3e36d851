"""Following: what was shown is followed while it is made, the same however frames are cut, and nothing else."""

import importlib.util
from itertools import pairwise
from pathlib import Path

import msgspec
import numpy as np
import pytest

from mossar_stream import (
    Event,
    FollowEvent,
    MoveEvent,
    Moves,
    MovesError,
    Performers,
    Segmenter,
    Settings,
    SnapshotError,
    segment_recording,
    to_json,
)

_PLACE = Path(__file__).parents[1] / "moves" / "conftest.py"
_spec = importlib.util.spec_from_file_location("people_who_move", _PLACE)
people = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(people)
FPS, PERSON, STANDING, performed, session = (
    people.FPS,
    people.PERSON,
    people.STANDING,
    people.performed,
    people.session,
)
ORDER = ["punch_left", "kick_right", "punch_left", "circle_left", "punch_left", "punch_right"]


@pytest.fixture(scope="module")
def moves():
    found = Moves(PERSON)
    for name in people.MOVES:
        found.add(name, performed(name), FPS)
    return found


@pytest.fixture(scope="module")
def take():
    return session(ORDER)


def events_of(segmenter, positions, times, size):
    events = []
    for at in range(0, len(times), size):
        events += segmenter.push(positions[at : at + size], times[at : at + size])
    return events + segmenter.end_take()


def followed(events, *statuses):
    return [e for e in events if isinstance(e, FollowEvent) and (not statuses or e.status in statuses)]


def lines_of(events):
    return [to_json(event) for event in events]


def test_every_performance_is_done_once_and_counted_by_name(moves, take):
    positions, times, truth = take
    done = followed(events_of(Segmenter(PERSON, moves=moves, follow=True), positions, times, 16), "done")
    assert [event.name for event in done] == [name for name, _, _ in truth]
    assert [event.count for event in done if event.name == "punch_left"] == [1, 2, 3]
    for event, (_, first, last) in zip(done, truth, strict=True):
        assert abs(event.start - times[first]) < 0.35
        assert abs(event.time - times[last]) < 0.35
        assert event.time <= event.decided_time < times[last] + 1.0
        assert 0.6 < event.tempo < 1.7
        assert event.deviation < 8
        assert event.progress == 1.0


def test_only_the_named_moves_are_followed(moves, take):
    positions, times, _ = take
    segmenter = Segmenter(PERSON, moves=moves, follow=["kick_right"])
    assert segmenter.follow == ("kick_right",)
    events = followed(events_of(segmenter, positions, times, 64))
    assert {event.name for event in events} == {"kick_right"}
    assert set(segmenter.following) == {"kick_right"}


def test_a_performance_begins_goes_on_and_ends_under_one_id(moves, take):
    positions, times, _ = take
    events = followed(events_of(Segmenter(PERSON, moves=moves, follow=True), positions, times, 5))
    for name in {event.id for event in events}:
        about = [event for event in events if event.id == name]
        assert [event.rev for event in about] == list(range(1, len(about) + 1))
        assert about[0].status in ("begun", "done")
        assert about[-1].status in ("done", "left")
        assert all(event.status == "progress" for event in about[1:-1])
        assert all(b.decided_time - a.decided_time > 0.06 for a, b in pairwise(about[:-1]))
    assert len({event.id for event in followed(events, "done")}) == len(ORDER)


def test_the_state_is_there_at_every_frame_and_progress_rises(moves, take):
    positions, times, truth = take
    segmenter = Segmenter(PERSON, moves=moves, follow=("circle_left",))
    seen = {}
    for i in range(len(times)):
        segmenter.push(positions[i], float(times[i]))
        state = segmenter.following["circle_left"]
        if state is not None:
            seen[i] = state
    _, first, last = next(t for t in truth if t[0] == "circle_left")
    within = [seen[i].progress for i in range(first, last) if i in seen]
    assert len(within) > 10
    assert within == sorted(within)
    assert set(seen[last - 3].limbs) == {"trunk", "left_arm", "right_arm", "left_leg", "right_leg"}


def test_the_limb_and_the_joint_that_stray_are_named(moves):
    positions, times, _ = session(["punch_left"])
    positions = positions.copy()
    # The right forearm hangs 23 degrees sideways.
    turn = np.array([np.sin(0.4), -np.cos(0.4), 0.0], np.float32)
    positions[:, 8] = positions[:, 7] + 0.25 * turn
    done = followed(
        events_of(Segmenter(PERSON, moves=moves, follow=("punch_left",)), positions, times, 9), "done"
    )
    assert len(done) == 1
    assert max(done[0].limbs, key=done[0].limbs.get) == "right_arm"
    assert done[0].joint == "right_wrist"
    assert 7 < done[0].limbs["right_arm"] < 9  # 23 degrees of one of three bones
    assert done[0].limbs["left_leg"] < 5


def test_range_says_how_far_it_went(moves):
    still = np.repeat(STANDING[None], 30, axis=0)
    small = np.concatenate([still, performed("kick_right", size=0.6), still]).astype(np.float32)
    times = np.arange(len(small)) / FPS
    done = followed(
        events_of(Segmenter(PERSON, moves=moves, follow=("kick_right",)), small, times, 9), "done"
    )
    assert [event.count for event in done] == [1]
    assert set(done[0].range) == {"right_leg"}
    assert 0.4 < done[0].range["right_leg"] < 0.85


def test_chunks_make_no_difference(moves, take):
    positions, times, _ = take
    wanted = lines_of(events_of(Segmenter(PERSON, moves=moves, follow=True), positions, times, len(times)))
    for size in (1, 7, 64):
        segmenter = Segmenter(PERSON, moves=moves, follow=True)
        assert lines_of(events_of(segmenter, positions, times, size)) == wanted
    one = Segmenter(PERSON, moves=moves, follow=True)
    single = [e for i in range(len(times)) for e in one.push(positions[i], float(times[i]))]
    assert lines_of([*single, *one.end_take()]) == wanted


def test_other_events_are_those_without_following(moves, take):
    positions, times, _ = take
    without = lines_of(events_of(Segmenter(PERSON, moves=moves), positions, times, 16))
    events = events_of(Segmenter(PERSON, moves=moves, follow=True), positions, times, 16)
    assert lines_of(e for e in events if not isinstance(e, FollowEvent)) == without


def test_a_snapshot_goes_on_in_the_middle_of_a_performance(moves, take):
    positions, times, _ = take
    whole = lines_of(events_of(Segmenter(PERSON, moves=moves, follow=True), positions, times, 1))
    for cut in range(20, 150, 7):
        first = Segmenter(PERSON, moves=moves, follow=True)
        events = [e for i in range(cut) for e in first.push(positions[i], float(times[i]))]
        second = Segmenter.restore(first.snapshot())
        assert second.follow is True
        assert second.following == first.following
        rest = [*second.push(positions[cut:], times[cut:]), *second.end_take()]
        assert lines_of([*events, *rest]) == whole


def test_performers_and_recordings_say_the_same(moves, take):
    positions, times, _ = take
    alone = followed(events_of(Segmenter(PERSON, moves=moves, follow=True), positions, times, 1), "done")
    pool = Performers(moves=moves, follow=True)
    pool.announce("p1", PERSON)
    pool.announce("p2", PERSON)
    both = []
    for at in range(0, len(times), 8):
        chunk = np.stack([positions[at : at + 8]] * 2)
        both += pool.push_many(["p1", "p2"], chunk, times[at : at + 8])
    both += pool.end_takes()
    assert [e for e in followed(both, "done") if e.performer == "p1"] == alone
    restored = Performers(moves=moves, follow=("kick_right",))
    restored.restore(pool.snapshot(), pool.lasting())
    assert restored["p1"].follow == ("kick_right",)
    result = segment_recording(positions, skeleton=PERSON, times=times, moves=moves, follow=True)
    assert list(result.followed) == alone


@pytest.mark.parametrize(
    ("follow", "error", "says"),
    [
        (("punsh",), MovesError, "no move called 'punsh' to follow; there are punch_left"),
        ("punch_left", TypeError, "tuple of names"),
        (3, TypeError, "tuple of names"),
    ],
)
def test_what_cannot_be_followed_is_a_clear_error(moves, take, follow, error, says):
    positions, times, _ = take
    for build in (
        lambda: Segmenter(PERSON, moves=moves, follow=follow),
        lambda: Performers(moves=moves, follow=follow),
        lambda: segment_recording(positions, skeleton=PERSON, times=times, moves=moves, follow=follow),
    ):
        with pytest.raises(error, match=says):
            build()


def test_following_needs_moves():
    with pytest.raises(MovesError, match="without moves"):
        Segmenter(PERSON, follow=True)


def test_what_is_followed_changes_while_running(moves, take):
    positions, times, truth = take
    segmenter = Segmenter(PERSON, moves=moves, follow=("punch_left",))
    middle = (truth[0][1] + truth[0][2]) // 2
    events = segmenter.push(positions[:middle], times[:middle])
    segmenter.follow = ("kick_right",)
    events += segmenter.push(positions[middle:], times[middle:])
    statuses = [(event.name, event.status) for event in followed(events, "left", "done")]
    assert statuses[0] == ("punch_left", "left")
    assert ("kick_right", "done") in statuses
    assert len({event.id for event in followed(events)}) == len(statuses)
    segmenter.moves = None
    assert segmenter.following == {}
    segmenter.moves = moves
    assert segmenter.following == {"kick_right": None}


@pytest.mark.parametrize("moved", [False, True])
def test_performances_are_numbered_on_after_following_was_off(moves, take, moved):
    segmenter = Segmenter(moves.skeleton, moves=moves, follow=True)
    positions, times = take[:2]
    half = len(times) // 2
    events = [*segmenter.push(positions[:half], times[:half])]
    if moved:
        segmenter.moves = None
    else:
        segmenter.follow = ()
    events += segmenter.push(positions[half : half + 1], times[half : half + 1])
    segmenter = Segmenter.restore(segmenter.snapshot())
    segmenter.moves = moves
    segmenter.follow = True
    events += segmenter.push(positions[half + 1 :], times[half + 1 :]) + segmenter.end_take()
    first = [event.id for event in events if isinstance(event, FollowEvent) and event.rev == 1]
    recognised = [event.id for event in events if isinstance(event, MoveEvent) and event.rev == 1]
    assert len(first) == len(set(first)) > 2
    assert len(recognised) == len(set(recognised))


def test_events_come_back_from_every_wire(moves, take):
    positions, times, _ = take
    events = followed(events_of(Segmenter(PERSON, moves=moves, follow=True), positions, times, 64))
    for event in events:
        assert msgspec.json.decode(to_json(event), type=Event) == event
        assert msgspec.msgpack.decode(msgspec.msgpack.encode(event), type=Event) == event


def test_the_setting_follow_every_spaces_progress(moves, take):
    positions, times, _ = take
    counts = {
        every: len(
            followed(
                events_of(
                    Segmenter(PERSON, Settings(follow_every=every), moves=moves, follow=True),
                    positions,
                    times,
                    64,
                ),
                "progress",
            )
        )
        for every in (0.0, 0.3, 60.0)
    }
    assert counts[0.0] > 2 * counts[0.3] > 0
    assert counts[60.0] == 0


def test_a_damaged_state_is_refused(moves):
    alignment = Segmenter(PERSON, moves=moves, follow=True)._followers.alignment
    with pytest.raises(SnapshotError, match="bytes"):
        alignment.go_on_from(b"\0" * 10)
    with pytest.raises(SnapshotError, match="contradicts"):
        alignment.go_on_from(b"\xff" * len(alignment.to_bytes()))


def test_the_whole_of_an_example_is_kept_and_old_files_are_read():
    moves = Moves(PERSON)
    still = np.repeat(STANDING[None], 45, axis=0)
    moves.add("punch", np.concatenate([still, performed("punch_left"), still]), FPS)
    example = moves.examples[0]
    whole, rate = example.shown(len(PERSON))
    assert (len(whole), rate) == (27 + 90, FPS)
    assert len(example.metres(len(PERSON))) < 27 + 12
    again = Moves.from_json(moves.to_json())
    assert again.examples == moves.examples
    old = msgspec.json.decode(moves.to_json())
    old["version"] = 1
    for one in old["examples"]:
        del one["whole"], one["whole_fps"]
    read = Moves.from_json(msgspec.json.encode(old))
    assert len(read.examples[0].shown(len(PERSON))[0]) == len(example.metres(len(PERSON)))
    Segmenter(PERSON, moves=read, follow=True)


@pytest.mark.parametrize("change", [{"whole": [1, 2]}, {"whole_fps": 0}, {"whole": []}, {"whole_fps": -1}])
def test_a_damaged_whole_is_refused(change):
    moves = Moves(PERSON)
    still = np.repeat(STANDING[None], 45, axis=0)
    moves.add("punch", np.concatenate([still, performed("punch_left"), still]), FPS)
    content = msgspec.json.decode(moves.to_json())
    content["examples"][0] |= change
    with pytest.raises(MovesError):
        Moves.from_json(msgspec.json.encode(content))
