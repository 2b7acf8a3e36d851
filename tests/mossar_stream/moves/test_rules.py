"""Strictness and pause of a move, what explanations say, and examples that are unlike the others."""

import numpy as np
import pytest

from mossar_stream import MoveEvent, Moves, MovesError, Performers, Segmenter, SnapshotError
from mossar_stream.events import to_json

from .conftest import FPS, MOVES, PERSON, STANDING, performed, session

ORDER = ["punch_left", "kick_right", "punch_left", "punch_left", "circle_left"]


@pytest.fixture(scope="module")
def take():
    return session(ORDER, rest=0.8)


def run(moves, positions, size=64):
    segmenter = Segmenter(PERSON, moves=moves, fps=FPS)
    events = []
    for at in range(0, len(positions), size):
        events += segmenter.push(positions[at : at + size])
    return [event for event in events + segmenter.end_take() if isinstance(event, MoveEvent)]


def confirmed(events):
    return [event.name for event in events if event.status == "confirmed"]


def with_rule(moves, name, **rule):
    mine = moves.copy()
    mine.set_rule(name, **rule)
    return mine


def test_a_strict_move_wants_to_be_almost_the_same(moves, take):
    positions = take[0]
    rng = np.random.default_rng(2)
    noise = np.repeat(rng.normal(0, 0.02, (len(positions) // 10 + 1, 15, 3)), 10, axis=0)
    sloppy = positions + noise[: len(positions)].astype(np.float32)
    counts = [
        confirmed(run(with_rule(moves, "punch_left", strict=strict), sloppy)).count("punch_left")
        for strict in (0.0, 0.5, 0.8, 1.0)
    ]
    assert counts == [3, 2, 1, 0]
    assert confirmed(run(with_rule(moves, "punch_left", strict=1.0), sloppy)) == ["kick_right", "circle_left"]


def test_a_move_is_confirmed_again_after_its_pause(moves, take):
    positions = take[0]
    times = [
        e.decided_time for e in run(moves, positions) if (e.name, e.status) == ("punch_left", "confirmed")
    ]
    assert len(times) == 3
    gaps = np.diff(times)
    assert gaps[1] < gaps[0]
    pause = (gaps[0] + gaps[1]) / 2
    mine = with_rule(moves, "punch_left", again=float(pause))
    assert confirmed(run(mine, positions)) == ["punch_left", "kick_right", "punch_left", "circle_left"]
    assert [to_json(e) for e in run(mine, positions, 1)] == [to_json(e) for e in run(mine, positions)]


def test_a_pause_goes_on_over_snapshots_and_changes_of_the_moves(moves, take):
    positions, times, truth = take
    mine = with_rule(moves, "punch_left", again=60.0)
    cut = truth[1][1] - 5
    segmenter = Segmenter(PERSON, moves=mine, fps=FPS)
    events = segmenter.push(positions[:cut])
    same = Segmenter.restore(segmenter.snapshot())
    mine.remove("circle_left")
    segmenter.moves = mine
    for one, wanted in (
        (same, ["punch_left", "kick_right", "circle_left"]),
        (segmenter, ["punch_left", "kick_right"]),
    ):
        rest = [*one.push(positions[cut:], times[cut:]), *one.end_take()]
        found = confirmed(e for e in [*events, *rest] if isinstance(e, MoveEvent))
        assert found == wanted


def test_explanations_change_no_event_and_name_what_kept_a_move(moves, take):
    positions = take[0]
    said = []
    mine = with_rule(moves, "punch_left", again=60.0)
    mine.explained = said.append
    plain = with_rule(moves, "punch_left", again=60.0)
    for size in (1, 7, 64):
        said.clear()
        assert [to_json(e) for e in run(mine, positions, size)] == [
            to_json(e) for e in run(plain, positions, size)
        ]
        named = [one for one in said if one.reason in ("", "pause")]
        assert [one.nearest for one in named] == ORDER
        assert [one.reason for one in named] == ["", "", "pause", "pause", ""]
        for one in named:
            assert one.start < one.end
            assert 0.0 < one.cost < one.most
            assert one.lead > 1.0
            assert one.second in MOVES


class Raising:
    """Notes explanations, and raises at one of them."""

    def __init__(self, at):
        self.at, self.said = at, []

    def __call__(self, explanation):
        self.said.append(explanation)
        if len(self.said) == self.at:
            raise ArithmeticError


@pytest.mark.parametrize("size", [1, 64, 1000])
@pytest.mark.parametrize("at", range(1, 6))
def test_an_exception_in_explained_loses_no_frame_no_event_and_no_other_explanation(moves, take, at, size):
    positions, times = take[0], take[1]
    plain, noted = moves.copy(), Raising(0)
    plain.explained = noted
    segmenter = Segmenter(PERSON, moves=plain, follow=True)
    expected = [*segmenter.push(positions, times), *segmenter.end_take()]
    mine, raising = moves.copy(), Raising(at)
    mine.explained = raising
    segmenter, events, raised = Segmenter(PERSON, moves=mine, follow=True), [], 0
    for begin in range(0, len(times), size):
        try:
            events += segmenter.push(positions[begin : begin + size], times[begin : begin + size])
        except ArithmeticError:
            raised += 1
    assert raised == 1
    assert segmenter.stats["frames"] == len(times)
    assert [*events, *segmenter.end_take()] == expected
    assert raising.said == noted.said


def test_an_exception_in_explained_loses_nothing_of_others_in_a_pool(moves, take):
    positions, times = take[0], take[1]
    both = np.stack([positions, positions])
    found, said = {}, {}
    for at in (0, 1):
        mine, raising = moves.copy(), Raising(at)
        mine.explained = raising
        pool = Performers(moves=mine)
        for name in ("a", "b"):
            pool.announce(name, PERSON)
        found[at] = []
        try:
            found[at] += pool.push_many(("a", "b"), both, times)
        except ArithmeticError:
            assert [pool[name].stats["frames"] for name in "ab"] == [len(times)] * 2
        found[at] += pool.end_takes()
        said[at] = raising.said
    in_order = [sorted(map(to_json, found[at])) for at in (0, 1)]
    assert in_order[0] == in_order[1]
    assert sorted(map(repr, said[0])) == sorted(map(repr, said[1]))


@pytest.mark.parametrize(
    ("kind", "reasons"), [("posture", {"posture", "cost"}), ("movement", {"cost", "posture"})]
)
def test_explanations_of_what_is_no_move(moves, kind, reasons):
    still = np.repeat(STANDING[None], 40, axis=0)
    movement = performed("punch_left")
    if kind == "posture":  # sitting, with the legs stretched out
        movement[:, [10, 11, 13, 14]] += [0, 0.5, 0.5]
        still[:, [10, 11, 13, 14]] += [0, 0.5, 0.5]
    else:
        movement[:, [4, 5, 13]] = performed("kick_right")[:, [10, 11, 8]] + 0.2 * np.sin(
            np.linspace(0, 9, len(movement))
        ).reshape(-1, 1, 1)
    said = []
    mine = moves.copy()
    mine.explained = said.append
    events = run(mine, np.concatenate([still, movement, still]).astype(np.float32))
    assert confirmed(events) == []
    assert said
    assert {one.reason for one in said} <= reasons
    if kind == "posture":
        assert min(said, key=lambda one: one.cost).nearest == "punch_left"
        assert max(one.posture for one in said) > 1.5


def test_an_example_that_is_cut_short_is_unlike_the_others():
    moves = Moves(PERSON)
    for seed in range(2):
        moves.add("punch", performed("punch_left", seconds=1.2, seed=seed), FPS)
    moves.add("punch", performed("punch_left", seconds=0.4), FPS)
    assert moves.oddity(0) is None
    odd = moves.oddity(2)
    assert "duration" in odd.differences
    assert odd.seconds < odd.others / 2


def test_another_posture_and_another_movement_are_unlike():
    moves = Moves(PERSON)
    moves.add("punch", performed("punch_left"), FPS)
    moves.add("kick", performed("kick_right"), FPS)
    assert moves.oddity(0) is None  # the only one of its name
    bent = performed("punch_left", seed=1)
    bent[:, [7, 8]] += [0.5, 0.8, 0.2]
    moves.add("punch", bent, FPS)
    assert "posture" in moves.oddity(2).differences
    moves.add("kick", performed("punch_left", seed=2), FPS)
    odd = moves.oddity(3)
    assert "movement" in odd.differences
    assert odd.nearer == "punch"
    with pytest.raises(MovesError, match="no example 9"):
        moves.oddity(9)


def test_a_snapshot_with_a_nearest_move_that_is_none_is_refused(moves):
    recognition = Segmenter(PERSON, moves=moves).recognition
    content = np.frombuffer(recognition.to_bytes(), np.uint8).copy()
    recognition.parts(content)["state"]["nearest"]["move"] = 99
    with pytest.raises(SnapshotError, match="contradicts"):
        recognition.go_on_from(content.tobytes())
