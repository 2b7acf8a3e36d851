"""The plan: names of moves, their order, pauses and true cuts."""

import itertools

import numpy as np
import pytest

from mossar_adapters.demo.plan import FIRST_ROUND, MOVES, MoveRequest, beats, default_moves, parse_move
from mossar_adapters.demo.script import Stance
from mossar_stream import SettingsError


def planned(seed, *moves, tempo=1.0):
    rng = np.random.default_rng(seed)
    return list(beats(iter([parse_move(move) for move in moves]), rng, Stance(), tempo))


def test_moves_are_read_with_side_and_length():
    assert parse_move("punch") == MoveRequest("punch")
    assert parse_move(" kick_left ") == MoveRequest("kick", "left")
    assert parse_move("stand:20") == MoveRequest("stand", "", 20.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("dance", "no move is called 'dance'; there are rest, walk, punch"),
        ("", "no move is called ''"),
        ("jump_left", "sides can be chosen as punch_left"),
        ("punch_", "sides can be chosen as"),
        ("punch_up", "sides can be chosen as"),
        ("walk:3", "only rest and stand have a length"),
        ("stand:0", "only rest and stand have a length"),
        ("stand:nan", "in seconds from 0 to 86400"),
        ("rest:long", "only rest and stand have a length"),
    ],
)
def test_a_move_that_does_not_exist_is_refused_with_what_does(text, message):
    with pytest.raises(SettingsError, match=message):
        parse_move(text)


@pytest.mark.parametrize("seed", range(5))
def test_first_round_has_every_kind_but_stand_and_goes_from_rest_to_rest(seed):
    moves = list(itertools.islice(default_moves(np.random.default_rng(seed)), FIRST_ROUND))
    assert {move.kind for move in moves} == set(MOVES) - {"stand"}
    assert moves[0].kind == moves[-1].kind == "rest"


@pytest.mark.parametrize("seed", range(5))
def test_by_default_no_kind_follows_itself_and_no_walk_a_turn(seed):
    moves = itertools.islice(default_moves(np.random.default_rng(seed)), 10 * FIRST_ROUND)
    for before, after in itertools.pairwise(moves):
        assert before.kind != after.kind
        assert {before.kind, after.kind} != {"turn", "walk"}


def test_a_cut_lies_in_the_middle_of_a_brisk_change_of_posture():
    kinds = set()
    for before, after in itertools.pairwise(planned(3, *["punch", "kick", "jump", "wave"] * 10)):
        change = 2 * (after.cut - after.start)
        pause = 2 * (after.start - before.end)
        assert 0.25 <= change <= 0.3
        assert pause == pytest.approx(0) if after.cut_kind == "flow" else 0.1 <= pause <= 0.2
        kinds.add(after.cut_kind)
    assert kinds == {"pause", "flow"}


def test_the_performer_comes_to_a_rest_and_out_of_it_without_a_pause():
    punch, rest, kick = planned(1, "punch", "rest", "kick")
    assert (rest.start, rest.cut_kind) == (punch.end, "rest")
    assert (kick.start, kick.cut_kind) == (rest.end, "rest")
    assert punch.cut is None


@pytest.mark.parametrize("kind", ["walk", "punch", "kick", "jump", "wave", "squat", "turn"])
def test_moves_last_about_as_long_as_the_motions_of_the_paper(kind):
    for seed in range(5):
        move = planned(seed, "rest", kind)[1]
        assert 1.5 < move.end - move.cut < 3.6


def test_there_is_no_cut_between_two_rests():
    assert [beat.cut for beat in planned(1, "rest", "stand:5", "rest")] == [None] * 3


def test_names_tell_the_side_that_was_chosen():
    names = {beat.name for beat in planned(2, *["punch", "turn"] * 10, "jump", "walk")}
    assert names == {"punch_left", "punch_right", "turn_left", "turn_right", "jump", "walk"}


def test_double_tempo_halves_the_time_of_moves_and_changes_but_not_of_falling():
    slow, fast = (planned(4, "wave", "kick", tempo=tempo)[-1] for tempo in (1.0, 2.0))
    assert fast.end == pytest.approx(slow.end / 2)
    slow, fast = (planned(4, "rest", "jump", tempo=tempo)[1] for tempo in (1.0, 2.0))
    assert fast.end - (2 * fast.cut - fast.start) == pytest.approx(slow.end - (2 * slow.cut - slow.start))
