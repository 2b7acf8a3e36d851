"""Figures in text: an example drawn with characters."""

import numpy as np
import pytest

from mossar_adapters.demo.body import SKELETON
from mossar_adapters.demo.take import performance
from mossar_stream import Moves, Skeleton
from mossar_tools.figures_in_text import POSES, example_lines, figure_lines

from .test_teach import FPS, PERSON, PUNCH


@pytest.fixture(scope="module")
def squat():
    take = performance(1, moves=["rest", "squat", "rest"])
    moves = Moves(SKELETON)
    moves.add("squat", take.frames.positions, take.fps)
    return moves.examples[0]


@pytest.mark.parametrize("fine", [True, False])
def test_an_example_fits_a_terminal(squat, fine):
    lines = example_lines(squat, SKELETON, fine=fine)
    assert len(lines) == 6
    assert max(map(len, lines)) < 60
    assert all(line == line.rstrip() for line in lines)
    known = set("".join(lines)) - {" "}
    assert known == {"*"} if not fine else all(0x2800 < ord(sign) < 0x2900 for sign in known)


def test_what_goes_down_is_drawn_lower():
    tall = np.array([[0.0, 1, 0], [0, 1.8, 0], [0, 0, 0]])
    low = tall * (1, 0.5, 1)
    body = Skeleton(("hip", "head", "foot"), (-1, 0, 0))
    poses = np.stack([tall, low])
    lines = figure_lines(poses, poses, body, fine=True)
    first, second = ([line.ljust(30)[at : at + 10].strip() for line in lines] for at in (0, 11))
    assert first[0]
    assert not second[0]
    assert second[-1] or second[-2]


def test_poses_are_spread_along_the_path_of_an_example():
    moves = Moves(PERSON)
    moves.add("punch", PUNCH, FPS)
    lines = example_lines(moves.examples[0], PERSON, fine=True)
    blocks = [[line.ljust(60)[11 * k : 11 * k + 10] for line in lines] for k in range(POSES)]
    assert blocks[0] == blocks[-1]
    assert blocks[0] != blocks[POSES // 2]
