"""Near misses: what is nearly the shown movement counts once the next performance is like it; and why others are left."""

import msgspec
import numpy as np
import pytest

from mossar_stream import Event, Segmenter, SnapshotError, to_json
from mossar_stream.core.kernels import RECORDS, follow_memory_parts
from mossar_stream.moves.parts import parts_of

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
REST = np.repeat(STANDING[None], 30, axis=0)


def with_both_hands(share=1.0, seconds=0.9):
    """Return a punch of the left hand, together with one of the right hand."""
    return (
        performed("punch_left", seconds)
        + share * (performed("punch_right", seconds) - performed("punch_right", seconds)[0])
    ).astype(np.float32)


def stream(*parts):
    """Return positions and times of performances with rest between them."""
    frames = [REST]
    for part in parts:
        frames += [part, REST]
    positions = np.concatenate(frames).astype(np.float32)
    return positions, np.arange(len(positions)) / FPS


def follower(moves):
    return Segmenter(PERSON, moves=moves, follow=("punch_left",))


def ends_of(moves, *parts, size=16):
    return followed(events_of(follower(moves), *stream(*parts), size), "done", "left")


def test_one_that_is_nearly_the_move_is_left_and_says_so(moves):
    ends = ends_of(moves, with_both_hands())
    assert [(event.status, event.reason, event.count) for event in ends] == [("left", "once", 0)]


def test_two_that_are_alike_are_both_done_the_first_one_late_under_an_id_of_its_own(moves):
    left, first, second = ends_of(moves, with_both_hands(), with_both_hands())
    assert (left.status, left.reason) == ("left", "once")
    assert [(event.status, event.count, event.reason) for event in (first, second)] == [
        ("done", 1, ""),
        ("done", 2, ""),
    ]
    assert len({left.id, first.id, second.id}) == 3
    assert first.rev == 1
    assert second.rev > 1
    assert first.progress == second.progress == 1.0
    assert abs(first.start - left.start) < 0.2
    assert first.time < second.start < second.time <= first.decided_time <= second.decided_time
    assert first.deviation == pytest.approx(second.deviation, abs=1.0)
    assert set(first.range) == set(second.range) == {"left_arm"}
    assert first.score > 0


def test_those_that_follow_are_counted_at_once(moves):
    done = [event for event in ends_of(moves, *[with_both_hands()] * 5) if event.status == "done"]
    assert [event.count for event in done] == [1, 2, 3, 4, 5]
    assert all(event.decided_time - event.time < 0.6 for event in done[1:])


def test_two_that_are_unlike_are_not_done(moves):
    kicking = performed("punch_left") + 1.2 * (performed("kick_right") - STANDING)
    ends = ends_of(moves, with_both_hands(), kicking)
    assert [(event.status, event.reason) for event in ends] == [("left", "once")] * 2


def test_two_with_a_long_rest_between_them_are_not_done(moves):
    ends = ends_of(moves, with_both_hands(), np.concatenate([REST] * 10), with_both_hands())
    assert [event.status for event in ends] == ["left"] * 2


def test_a_gap_forgets_the_one_before(moves):
    positions, times = stream(with_both_hands(), with_both_hands())
    gap = np.where(np.arange(len(times)) >= 75, 5.0, 0.0)  # between the two
    ends = followed(events_of(follower(moves), positions, times + gap, 16), "done", "left")
    assert [event.status for event in ends] == ["left"] * 2


def test_the_second_one_may_end_with_the_take(moves):
    positions, times = stream(with_both_hands(), with_both_hands())
    stop = len(times) - len(REST) + 1
    segmenter = follower(moves)
    before = followed(segmenter.push(positions[:stop], times[:stop]), "done")
    last = followed(segmenter.end_take(), "done")
    assert [event.count for event in [*before, *last]] == [1, 2]
    assert last


def test_chunks_and_snapshots_make_no_difference(moves):
    positions, times = stream(with_both_hands(), with_both_hands(), with_both_hands())
    whole = lines_of(events_of(follower(moves), positions, times, len(times)))
    for size in (1, 7):
        assert lines_of(events_of(follower(moves), positions, times, size)) == whole
    for cut in range(50, len(times), 5):
        first = follower(moves)
        events = first.push(positions[:cut], times[:cut])
        second = Segmenter.restore(first.snapshot())
        events += [*second.push(positions[cut:], times[cut:]), *second.end_take()]
        assert lines_of(events) == whole


def test_one_that_stops_on_the_way_is_unfinished(moves):
    start = performed("circle_left")[:10]
    positions, times = stream(np.concatenate([start, start[::-1]]))
    segmenter = Segmenter(PERSON, moves=moves, follow=("circle_left",))
    ends = followed(events_of(segmenter, positions, times, 16), "done", "left")
    assert [(event.status, event.reason) for event in ends] == [("left", "unfinished")]


def test_a_gap_is_the_reason(moves):
    positions, times = stream(performed("punch_left"))
    keep = np.r_[0:45, 60 : len(times)]
    ends = followed(events_of(follower(moves), positions[keep], times[keep], 16), "left")
    assert [event.reason for event in ends] == ["gap"]


def test_another_move_that_fits_better_is_the_reason(moves):
    both = moves.copy()
    for place in range(2):
        both.add("double", with_both_hands(1.0 - 0.01 * place), FPS)
    positions, times = stream(with_both_hands())
    segmenter = Segmenter(PERSON, moves=both, follow=("double", "punch_left"))
    ends = followed(events_of(segmenter, positions, times, 16), "done", "left")
    assert {(event.name, event.status, event.reason) for event in ends} >= {("double", "done", "")}
    assert {event.reason for event in ends if event.name == "punch_left"} == {"another"}


def held_sideways(positions, degrees):
    """Return the positions with the right arm straight, held out to its side."""
    positions, angle = positions.copy(), np.radians(degrees)
    way = np.array([np.sin(angle), -np.cos(angle), 0.0], np.float32)
    for k in (7, 8):
        positions[:, k] = positions[:, 6] + 0.25 * (k - 6) * way
    return positions


def test_a_standing_difference_is_the_posture(moves):
    plain, _ = stream(performed("punch_left"))
    _, times = stream(performed("punch_left"))
    seen = {}
    for degrees in (10.0, 40.0):
        positions = held_sideways(plain, degrees)
        (done,) = followed(events_of(follower(moves), positions, times, 16), "done")
        seen[degrees] = done
        assert done.posture == pytest.approx(done.deviation, abs=0.6)
        assert done.posture > 0.5
    assert seen[40.0].posture > seen[10.0].posture + 2


def test_a_movement_that_differs_is_no_posture(moves):
    moved = performed("punch_left") + 0.6 * (performed("kick_right") - STANDING)
    (done,) = ends_of(moves, moved)
    assert done.deviation > 1.8
    assert done.posture < 0.75 * done.deviation
    state = follower(moves)
    positions, times = stream(moved)
    for at in range(45):
        state.push(positions[at], float(times[at]))
    now = state.following["punch_left"]
    assert 0.0 <= now.posture <= now.deviation


def test_events_come_back_and_old_ones_are_read(moves):
    for event in ends_of(moves, with_both_hands(), with_both_hands()):
        line = to_json(event)
        assert msgspec.json.decode(line, type=Event) == event
        old = msgspec.json.decode(line)
        del old["posture"], old["reason"]
        assert msgspec.json.decode(msgspec.json.encode(old), type=Event).posture == 0.0


@pytest.fixture(scope="module")
def after_one(moves):
    segmenter = follower(moves)
    positions, times = stream(with_both_hands())
    segmenter.push(positions, times)
    return segmenter._followers.alignment


def changed(alignment, name, change):
    memory = alignment.state.copy()
    change(parts_of(memory, follow_memory_parts(alignment.store))[name])
    return memory.tobytes()


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("example", 7.0),
        ("example", 0.5),
        ("joint", 99.0),
        ("joint", -2.0),
        ("count", np.nan),
        ("refused", 9.0),
    ],
)
def test_a_report_that_cannot_be_made_an_event_is_refused(after_one, field, value):
    place = RECORDS["FollowReport"].names.index(field)

    def change(reports):
        reports[0, place] = value

    with pytest.raises(SnapshotError, match="contradicts itself"):
        after_one.go_on_from(changed(after_one, "near_reports", change))


@pytest.mark.parametrize("name", ["near_boxes", "near_poses"])
def test_directions_that_are_none_are_refused(after_one, name):
    def change(directions):
        directions.flat[0] = np.nan

    with pytest.raises(SnapshotError, match="contradicts itself"):
        after_one.go_on_from(changed(after_one, name, change))
    after_one.go_on_from(after_one.to_bytes())


@pytest.mark.parametrize(
    "field",
    [("refused", -1), ("refused", 7), ("near", (2, 0, 0.0, 0, 1)), ("near", (1, 0, 0.0, -(2**62), 1))],
)
def test_a_near_miss_that_cannot_be_is_refused(after_one, field):
    name, value = field

    def change(known):
        known[name][0] = value

    with pytest.raises(SnapshotError, match="contradicts itself"):
        after_one.go_on_from(changed(after_one, "moves", change))
