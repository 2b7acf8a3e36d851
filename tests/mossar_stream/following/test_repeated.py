"""Repeated: what is nearly the shown movement counts once it is repeated; and why others are left."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from checks.following import followed as examples_followed
from checks.following import person_of
from mossar_stream import (
    Event,
    Performers,
    Segmenter,
    Settings,
    SnapshotError,
    segment_recording,
    to_json,
)
from mossar_stream.core.kernels import CYCLES, follow_memory_parts
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
PEOPLE = Path(__file__).parents[4] / "shared" / "data" / "quality" / "ui_prmd"
REST = np.repeat(STANDING[None], 30, axis=0)


def with_both_hands(share=1.0, seconds=0.9):
    """Return a punch of the left hand, together with one of the right hand."""
    return (
        performed("punch_left", seconds)
        + share * (performed("punch_right", seconds) - performed("punch_right", seconds)[0])
    ).astype(np.float32)


def swung(share=0.95):
    """Return a punch of the left hand that swings out in a circle."""
    circle = performed("circle_left")
    return (performed("punch_left") + share * (circle - circle[0])).astype(np.float32)


def stream(*parts):
    """Return positions and times of performances with rest between them."""
    frames = [REST]
    for part in parts:
        frames += [part, REST]
    positions = np.concatenate(frames).astype(np.float32)
    return positions, np.arange(len(positions)) / FPS


def follower(moves, **settings):
    return Segmenter(PERSON, Settings(**settings), moves=moves, follow=("punch_left",))


def ends_of(moves, *parts, size=16):
    return followed(events_of(follower(moves), *stream(*parts), size), "done", "left")


def test_one_that_is_nearly_the_move_is_left_and_says_so(moves):
    ends = ends_of(moves, swung())
    assert [(event.status, event.reason, event.count) for event in ends] == [("left", "once", 0)]


def test_two_in_a_row_are_both_done_late_under_ids_of_their_own(moves):
    *left, first, second = ends_of(moves, swung(), swung())
    assert [(event.status, event.reason) for event in left] == [("left", "once")] * 2
    assert [(event.status, event.count, event.reason) for event in (first, second)] == [
        ("done", 1, ""),
        ("done", 2, ""),
    ]
    assert len({event.id for event in (*left, first, second)}) == 4
    assert first.rev == second.rev == 1
    assert first.progress == second.progress == 1.0
    assert abs(first.start - left[0].start) < 0.2
    assert first.start < first.time <= second.start < second.time <= first.decided_time <= second.decided_time
    assert first.deviation == pytest.approx(second.deviation, abs=3.0)  # half of the rest belongs to it
    assert set(first.range) == set(second.range) == {"left_arm"}
    assert first.score > 0
    assert 0.6 < first.tempo < 1.7


def test_those_that_follow_are_counted_at_once(moves):
    done = [event for event in ends_of(moves, *[swung()] * 5) if event.status == "done"]
    assert [event.count for event in done] == [1, 2, 3, 4, 5]
    assert all(event.decided_time - event.time < 0.6 for event in done[2:])


def test_repetitions_that_ways_have_found_are_not_counted_again(moves):
    parts = [performed("punch_left", seed=seed) for seed in range(6)]
    done = [event for event in ends_of(moves, *parts) if event.status == "done"]
    assert [event.count for event in done] == [1, 2, 3, 4, 5, 6]
    assert all(event.decided_time - event.time < 0.6 for event in done)


def test_small_ones_that_no_way_finds_are_counted_late(moves):
    circle = performed("circle_left")
    small = (performed("punch_left", size=0.2) + 0.2 * (circle - circle[0])).astype(np.float32)
    assert ends_of(moves, small) == []
    done = ends_of(moves, *[small] * 4)
    assert [(event.status, event.count) for event in done] == [("done", n) for n in range(1, len(done) + 1)]
    assert len(done) >= 3
    assert all(event.range["left_arm"] < 0.6 for event in done)
    assert done[0].decided_time - done[0].time > 1.0


def test_another_movement_does_not_count_because_it_is_repeated(moves):
    for name in ("punch_right", "kick_right"):
        ends = ends_of(moves, *[performed(name).astype(np.float32)] * 6)
        assert [event for event in ends if event.status == "done"] == []


def test_without_the_counter_nothing_is_counted_late(moves):
    positions, times = stream(*[swung()] * 4)
    for settings, count in (({"level": "cluster"}, 0), ({"level": "cluster", "repetitions": True}, 4)):
        done = followed(events_of(follower(moves, **settings), positions, times, 16), "done")
        assert len(done) == count


def test_two_that_are_unlike_are_not_done(moves):
    kicking = performed("punch_left") + 1.2 * (performed("kick_right") - STANDING)
    ends = ends_of(moves, with_both_hands(), kicking)
    assert [(event.status, event.reason) for event in ends] == [("left", "once")] * 2


def test_two_with_a_long_rest_between_them_are_not_done(moves):
    ends = ends_of(moves, swung(), np.concatenate([REST] * 10), swung())
    assert [event.status for event in ends] == ["left"] * 2


def test_a_gap_forgets_the_one_before(moves):
    positions, times = stream(swung(), swung())
    gap = np.where(np.arange(len(times)) >= 75, 5.0, 0.0)  # between the two
    ends = followed(events_of(follower(moves), positions, times + gap, 16), "done", "left")
    assert [event.status for event in ends] == ["left"] * 2


def test_the_second_one_may_end_with_the_take(moves):
    positions, times = stream(swung(), swung())
    stop = len(times) - len(REST) + 3
    segmenter = follower(moves)
    before = followed(segmenter.push(positions[:stop], times[:stop]), "done")
    last = followed(segmenter.end_take(), "done")
    assert [event.count for event in [*before, *last]] == [1, 2]
    assert last


def test_the_next_take_begins_anew(moves):
    positions, times = stream(*[swung()] * 3)
    segmenter = follower(moves)
    first = followed(events_of(segmenter, positions, times, 16), "done")
    again = followed(events_of(segmenter, positions, times + times[-1] + 1.0, 16), "done")
    assert [event.count for event in first] == [event.count for event in again] == [1, 2, 3]
    once = followed(events_of(segmenter, *stream(swung()), 16), "done")
    assert once == []


def test_chunks_and_snapshots_make_no_difference(moves):
    positions, times = stream(*[swung()] * 4)
    whole = lines_of(events_of(follower(moves), positions, times, len(times)))
    for size in (1, 7):
        assert lines_of(events_of(follower(moves), positions, times, size)) == whole
    for cut in range(50, len(times), 5):
        first = follower(moves)
        events = first.push(positions[:cut], times[:cut])
        second = Segmenter.restore(first.snapshot())
        events += [*second.push(positions[cut:], times[cut:]), *second.end_take()]
        assert lines_of(events) == whole


def test_many_at_once_and_a_recording_are_as_one_alone(moves):
    positions, times = stream(*[swung()] * 4)
    alone = followed(events_of(follower(moves), positions, times, 64), "done")
    assert len(alone) == 4
    pool = Performers(moves=moves, follow=("punch_left",))
    pool.announce("p1", PERSON)
    pool.announce("p2", PERSON)
    both = [*pool.push_many(["p1", "p2"], np.stack([positions] * 2), times), *pool.end_takes()]
    assert [event for event in followed(both, "done") if event.performer == "p1"] == alone
    result = segment_recording(positions, skeleton=PERSON, times=times, moves=moves, follow=("punch_left",))
    assert list(result.followed) == alone


def test_of_two_followed_moves_a_repetition_is_the_one_that_it_is_like(moves):
    both = moves.copy()
    both.add("swing", swung(), FPS)
    positions, times = stream(*[swung()] * 4)
    segmenter = Segmenter(PERSON, moves=both, follow=("swing", "punch_left"))
    done = followed(events_of(segmenter, positions, times, 16), "done")
    assert [(event.name, event.count) for event in done] == [("swing", n) for n in (1, 2, 3, 4)]


@pytest.mark.parametrize(("person", "other"), [(0, 1), (3, 1)])
def test_a_way_back_that_is_like_the_way_there_does_not_count_twice(person, other):
    files = sorted(PEOPLE.glob("s*.npz"))
    if not files:
        pytest.skip("needs ../shared/data/quality/ui_prmd")
    made = person_of(files[person])["m05"]["right"]  # sits down and stands up
    events = examples_followed(person_of(files[other])["m05"]["right"][:1], made, mirrored=True)
    assert sum(event.status == "done" for event in events) == len(made)


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
    for event in ends_of(moves, swung(), swung()):
        line = to_json(event)
        assert msgspec.json.decode(line, type=Event) == event
        old = msgspec.json.decode(line)
        del old["posture"], old["reason"]
        assert msgspec.json.decode(msgspec.json.encode(old), type=Event).posture == 0.0


@pytest.fixture(scope="module")
def after_two(moves):
    segmenter = follower(moves)
    positions, times = stream(swung(), swung(), REST)
    segmenter.push(positions, times)
    return segmenter._followers.alignment


def changed(alignment, name, change):
    memory = alignment.state.copy()
    change(parts_of(memory, follow_memory_parts(alignment.store))[name])
    return memory.tobytes()


@pytest.mark.parametrize(
    ("field", "value"),
    [("cycles", -1), ("cycles", CYCLES + 1), ("origin", np.nan), ("origin", np.inf), ("origin", 1e300)],
)
def test_repetitions_that_cannot_be_are_refused(after_two, field, value):
    def change(periods):
        assert periods[0]["cycles"] == 2
        periods[0][field] = value

    with pytest.raises(SnapshotError, match="contradicts itself"):
        after_two.go_on_from(changed(after_two, "periods", change))


@pytest.mark.parametrize("field", ["begins", "ends"])
def test_a_repetition_at_no_time_is_refused(after_two, field):
    def change(periods):
        periods[0]["cycle"][1][field] = np.nan

    with pytest.raises(SnapshotError, match="contradicts itself"):
        after_two.go_on_from(changed(after_two, "periods", change))


@pytest.mark.parametrize("name", ["boxes", "rings"])
def test_directions_that_are_none_are_refused(after_two, name):
    def change(directions):
        directions.flat[0] = np.nan

    with pytest.raises(SnapshotError, match="contradicts itself"):
        after_two.go_on_from(changed(after_two, name, change))
    after_two.go_on_from(after_two.to_bytes())


@pytest.mark.parametrize("field", [("refused", -1), ("refused", 7), ("repeated", 2), ("surplus", -1)])
def test_a_move_that_cannot_be_is_refused(after_two, field):
    name, value = field

    def change(known):
        known[name][0] = value

    with pytest.raises(SnapshotError, match="contradicts itself"):
        after_two.go_on_from(changed(after_two, "moves", change))
