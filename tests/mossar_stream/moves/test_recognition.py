"""Recognition: moves are told apart soon after they were made, the same however frames are cut, and nothing else."""

import contextlib
import json
from pathlib import Path

import numpy as np
import pytest

from mossar_stream import (
    FrameError,
    MoveEvent,
    Moves,
    Performers,
    Segmenter,
    Skeleton,
    SnapshotError,
    segment_recording,
)
from mossar_stream.core.kernels import move_memory_bytes
from mossar_stream.events import to_json

from .conftest import FPS, MOVES, PERSON, session

ORDER = ["punch_left", "circle_left", "kick_right", "punch_right", "punch_left", "kick_right", "circle_left"]
KINECT = Path(__file__).parents[4] / "shared/data/moves/kinect"


@pytest.fixture(scope="module")
def take():
    return session(ORDER)


def events_of(segmenter, positions, times, size):
    events = []
    for at in range(0, len(times), size):
        events += segmenter.push(positions[at : at + size], times[at : at + size])
    return events + segmenter.end_take()


def moves_among(events, status="confirmed"):
    return [event for event in events if isinstance(event, MoveEvent) and event.status == status]


def test_every_move_is_recognised_once_and_soon(moves, take):
    positions, times, truth = take
    events = events_of(Segmenter(PERSON, moves=moves, fps=FPS), positions, times, 64)
    found = moves_among(events)
    assert [event.name for event in found] == [name for name, _, _ in truth]
    for event, (_, first, last) in zip(found, truth, strict=True):
        assert times[first] < event.decided_time < times[last] + 0.4
        assert event.start < event.end <= event.decided_time
    assert [event.limb for event in found] == [
        {
            "punch_left": "left_arm",
            "circle_left": "left_arm",
            "kick_right": "right_leg",
            "punch_right": "right_arm",
        }[name]
        for name in ORDER
    ]


def test_every_confirmed_move_ends_as_final_or_withdrawn(moves, take):
    positions, times, _ = take
    events = [
        e for e in events_of(Segmenter(PERSON, moves=moves), positions, times, 7) if isinstance(e, MoveEvent)
    ]
    for confirmed in moves_among(events):
        about = [event for event in events if event.id == confirmed.id]
        assert [event.rev for event in about] == [1, 2]
        assert about[1].status in ("final", "withdrawn")


def test_chunks_make_no_difference(moves, take):
    positions, times, _ = take
    wanted = [to_json(e) for e in events_of(Segmenter(PERSON, moves=moves), positions, times, len(times))]
    for size in (1, 7, 64):
        assert [
            to_json(e) for e in events_of(Segmenter(PERSON, moves=moves), positions, times, size)
        ] == wanted
    one = Segmenter(PERSON, moves=moves)
    single = [to_json(e) for i in range(len(times)) for e in one.push(positions[i], float(times[i]))]
    assert single + [to_json(e) for e in one.end_take()] == wanted


def test_other_events_are_those_without_moves(moves, take):
    positions, times, _ = take
    without = [to_json(e) for e in events_of(Segmenter(PERSON), positions, times, 16)]
    with_moves = events_of(Segmenter(PERSON, moves=moves), positions, times, 16)
    assert [to_json(e) for e in with_moves if not isinstance(e, MoveEvent)] == without


def test_a_snapshot_goes_on_in_the_middle_of_a_move(moves, take):
    positions, times, _ = take
    whole = [to_json(e) for e in events_of(Segmenter(PERSON, moves=moves), positions, times, 1)]
    for cut in range(35, 130, 9):
        first = Segmenter(PERSON, moves=moves)
        events = [to_json(e) for e in first.push(positions[:cut], times[:cut])]
        second = Segmenter.restore(first.snapshot())
        assert second.moves.names == moves.names
        rest = [*second.push(positions[cut:], times[cut:]), *second.end_take()]
        assert events + [to_json(e) for e in rest] == whole


def test_a_damaged_state_of_moves_is_refused(moves):
    recognition = Segmenter(PERSON, moves=moves).recognition
    with pytest.raises(SnapshotError, match="bytes"):
        recognition.go_on_from(b"\0" * 10)
    with pytest.raises(SnapshotError, match="contradicts"):
        recognition.go_on_from(b"\xff" * move_memory_bytes(15, len(moves.names)))


def test_rest_noise_and_other_movement_are_no_moves(moves):
    rng = np.random.default_rng(3)
    positions, _, _ = session([], rest=1.0)
    still = np.repeat(positions[:1], 600, axis=0) + rng.normal(0, 0.004, (600, 15, 3)).astype(np.float32)
    steps = np.cumsum(rng.normal(0, 0.01, (600, 15, 3)), axis=0).astype(np.float32)
    for frames in (still, positions[:1] + steps):
        events = events_of(
            Segmenter(PERSON, moves=moves), frames.astype(np.float32), np.arange(600) / FPS, 64
        )
        assert not moves_among(events)


@pytest.mark.parametrize("fps", [15.0, 60.0, 120.0, 240.0])
def test_the_rate_makes_no_difference(moves, take, fps):
    positions, times, truth = take
    moments = np.arange(0, times[-1], 1 / fps)
    flat = positions.reshape(len(times), -1)
    resampled = np.stack([np.interp(moments, times, column) for column in flat.T], axis=1).astype(np.float32)
    found = moves_among(events_of(Segmenter(PERSON, moves=moves), resampled.reshape(-1, 15, 3), moments, 64))
    assert [event.name for event in found] == [name for name, _, _ in truth]


def test_joints_that_are_missing_for_a_moment_do_no_harm(moves, take):
    positions, times, truth = take
    holes = positions.copy()
    rng = np.random.default_rng(5)
    holes[rng.random(holes.shape[:2]) < 0.02] = np.nan
    found = moves_among(events_of(Segmenter(PERSON, moves=moves), holes, times, 64))
    assert [event.name for event in found] == [name for name, _, _ in truth]


@pytest.mark.parametrize("size", [1, 64])
def test_arms_are_recognised_though_the_legs_were_never_seen(moves, take, size):
    positions, times, truth = take
    at_a_desk = positions.copy()
    at_a_desk[:, [10, 11, 13, 14]] = np.nan  # knees and ankles
    found = moves_among(events_of(Segmenter(PERSON, moves=moves, fps=FPS), at_a_desk, times, size))
    assert [event.name for event in found] == [name for name, _, _ in truth if name != "kick_right"]
    assert {event.limb for event in found} == {"left_arm", "right_arm"}


def test_nothing_is_recognised_while_the_centre_was_never_seen(moves, take):
    positions, times, _ = take
    without = positions.copy()
    without[:, 0] = np.nan
    assert not moves_among(events_of(Segmenter(PERSON, moves=moves, fps=FPS), without, times, 64))


def test_a_gap_ends_what_goes_on(moves, take):
    positions, times, truth = take
    _, first, last = truth[0]
    middle = (first + last) // 2
    late = times.copy()
    late[middle:] += 5.0
    found = moves_among(events_of(Segmenter(PERSON, moves=moves), positions, late, 64))
    assert [event.name for event in found] == [name for name, _, _ in truth[1:]]


def test_performers_share_moves_and_recordings_have_them(moves, take):
    positions, times, truth = take
    pool = Performers(moves=moves)
    for name in ("ann", "bob"):
        pool.announce(name, PERSON, FPS)
    events = pool.push_many(["ann", "bob"], np.stack([positions, positions]), times) + pool.end_takes()
    wanted = [name for name, _, _ in truth]
    for performer in ("ann", "bob"):
        assert [e.name for e in moves_among(events) if e.performer == performer] == wanted
    result = segment_recording(positions, FPS, PERSON, moves=moves)
    assert [event.name for event in result.moves] == wanted


def test_frames_without_a_time_change_nothing(moves, take):
    positions, times, truth = take
    segmenter, events = Segmenter(PERSON, moves=moves), []
    for i in range(len(times)):
        if i % 50 == 49:
            with contextlib.suppress(FrameError):
                events += segmenter.push(positions[i], float("nan"))
        events += segmenter.push(positions[i], float(times[i]))
    assert [event.name for event in moves_among(events)] == [name for name, _, _ in truth]


def test_moves_can_be_set_while_running(moves, take):
    positions, times, _truth = take
    segmenter = Segmenter(PERSON)
    only = Moves.from_json(moves.to_json())
    for name in MOVES.keys() - {"kick_right"}:
        only.remove(name)
    segmenter.push(positions[:10], times[:10])
    segmenter.moves = only
    found = moves_among([*segmenter.push(positions[10:], times[10:]), *segmenter.end_take()])
    assert {event.name for event in found} == {"kick_right"}
    segmenter.moves = None
    assert segmenter.moves is None


@pytest.mark.parametrize("left", [(), ("circle_left",)])
def test_a_move_is_final_when_what_recognises_from_now_on_does_not_know_it(moves, take, left):
    positions, times, truth = take
    only = Moves.from_json(moves.to_json())
    for name in MOVES.keys() - set(left):
        only.remove(name)
    segmenter, end, before = Segmenter(PERSON, moves=moves, fps=FPS), truth[0][1], []
    segmenter.push(positions[:end], times[:end])
    while not moves_among(before):
        before = segmenter.push(positions[end], float(times[end]))
        end += 1
    segmenter.moves = only if left else None
    after = segmenter.push(positions[end], float(times[end]))
    assert [event.id for event in moves_among(after, "final")] == [moves_among(before)[-1].id]
    assert moves_among([*after, *segmenter.end_take()]) == []


@pytest.mark.parametrize("pooled", [False, True])
def test_moves_shown_while_running_lose_nothing_and_numbers_go_on(moves, take, pooled):
    positions, times, truth = take
    mine = Moves.from_json(moves.to_json())
    mine.remove("kick_right")
    (kick,) = (example for example in moves.examples if example.name == "kick_right")
    pool = Performers(moves=mine)
    pool.announce("ann", PERSON, FPS)
    one = Segmenter(PERSON, moves=mine, performer="ann", fps=FPS)
    events = []
    for i in range(len(times)):
        if i == truth[1][2] + 8:  # a move has just been confirmed, and is not final yet
            mine.add("kick_right", kick.metres(len(PERSON)), kick.fps)
            pool.moves = one.moves = mine
        positions_now, time = positions[i : i + 1], times[i : i + 1]
        events += pool["ann"].push(positions_now, time) if pooled else one.push(positions_now, time)
    events += pool.end_takes() if pooled else one.end_take()
    assert [event.name for event in moves_among(events)] == [name for name, _, _ in truth]
    ids = [event.id for event in moves_among(events)]
    assert ids == [f"ann/move/0/{i + 1}" for i in range(len(truth))]
    assert [event.id for event in moves_among(events, "final")] == ids


def test_snapshots_may_leave_the_examples_to_the_program(moves, take):
    positions, times, _ = take
    whole = [to_json(e) for e in events_of(Segmenter(PERSON, moves=moves, fps=FPS), positions, times, 50)]
    segmenter, events = Segmenter(PERSON, moves=moves, fps=FPS), []
    for at in range(0, len(times), 50):
        blob = segmenter.snapshot(with_moves=False)
        assert len(blob) < len(segmenter.snapshot()) - len(moves.to_json()) // 2
        segmenter = Segmenter.restore(blob, moves)
        events += segmenter.push(positions[at : at + 50], times[at : at + 50])
    assert [to_json(event) for event in events + segmenter.end_take()] == whole
    with pytest.raises(SnapshotError, match="made without its moves"):
        Segmenter.restore(blob)


def test_a_snapshot_goes_on_with_other_moves_and_counts_on(moves, take):
    positions, times, truth = take
    cut = truth[3][1] - 10  # at rest
    segmenter = Segmenter(PERSON, moves=moves, fps=FPS)
    before = moves_among(segmenter.push(positions[:cut], times[:cut]))
    other = Moves.from_json(moves.to_json())
    other.remove("circle_left")
    again = Segmenter.restore(segmenter.snapshot(with_moves=False), other)
    after = moves_among(events_of(again, positions[cut:], times[cut:], 64))
    assert [event.name for event in before] == [name for name, _, _ in truth[:3]]
    assert [e.name for e in after][:3] == [name for name, _, _ in truth[3:6]]
    assert after[0].id == "p1/move/0/4"


def test_adding_to_moves_changes_nobody_who_has_them(moves, take):
    positions, times, _ = take
    mine = Moves.from_json(moves.to_json())
    segmenter, other = Segmenter(PERSON, moves=mine), Segmenter(PERSON, moves=moves)
    mine.remove("punch_left")
    for one in (segmenter, other):
        one.push(positions[:60], times[:60])
    assert segmenter.snapshot() == other.snapshot()
    assert Segmenter.restore(segmenter.snapshot()).moves.names == moves.names


@pytest.mark.skipif(not KINECT.is_dir(), reason="the recordings of moves are not here: ../shared/data/moves")
def test_a_real_session_on_command():
    file = KINECT / "sessions/U105.json"
    commands = json.loads(file.read_text())["commands"]
    data = np.load(file.with_suffix(".npz"))
    skeleton = Skeleton(tuple(map(str, data["joint_names"])), tuple(map(int, data["parents"])))
    moves = Moves(skeleton)
    samples = np.load(KINECT / "samples/U105.npz")
    for name in samples.files:
        moves.add(name.rsplit("_", 1)[0], samples[name], 30)
    segmenter = Segmenter(skeleton, fps=30, moves=moves)
    found = moves_among([*segmenter.push(data["positions"]), *segmenter.end_take()])
    right = sum(
        any(begin <= e.decided_time * 30 < end and e.name == name for begin, end, name in commands)
        for e in found
    )
    assert right >= 0.97 * len(found)
    assert right >= 0.95 * sum(
        1
        for here, after in zip(commands, [*commands[1:], None], strict=True)
        if not after or here[2] != after[2]
    )


@pytest.mark.parametrize("size", [1, 7, 1000])
def test_moves_end_with_the_take_of_a_body_that_nobody_sees(moves, take, size):
    positions, _, truth = take
    left = truth[0][2] + 2  # frame; the first move is over, and hardly anything follows it
    nobody = np.full((round(3 * FPS), *positions.shape[1:]), np.nan, np.float32)
    seen = np.concatenate([positions[:left], nobody, positions[left:]])
    events = events_of(Segmenter(PERSON, moves=moves, fps=FPS), seen, np.arange(len(seen)) / FPS, size)
    ended = next(k for k, event in enumerate(events) if getattr(event, "reason", "") == "nobody seen")
    before = [event for event in events[:ended] if isinstance(event, MoveEvent)]
    after = [event for event in events[ended + 1 :] if isinstance(event, MoveEvent)]
    assert [(event.name, event.status, event.take) for event in before] == [
        (truth[0][0], "confirmed", 0),
        (truth[0][0], "final", 0),
    ]
    assert all(event.take == 1 and event.start * FPS >= left + len(nobody) for event in after)
    assert [event.name for event in moves_among(after)] == [name for name, _, _ in truth[1:]]
