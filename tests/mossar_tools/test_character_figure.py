"""A performer in characters."""

import numpy as np
import pytest

from mossar_stream import Skeleton
from mossar_tools.character_figure import COLUMNS, ROWS, figure

SKELETON = Skeleton(("feet", "hips", "head", "hand"), (-1, 0, 1, 1))
STANDING = np.array([[0, 0, 0], [0, 0.9, 0], [0, 1.7, 0], [0.6, 0.9, 0]], np.float32)


@pytest.mark.parametrize("fine", [True, False])
def test_a_figure_stands_upright_and_reaches_to_the_side(fine):
    lines = figure(STANDING, SKELETON, fine=fine)
    assert [len(line) for line in lines] == [COLUMNS] * ROWS
    empty = "\u2800" if fine else " "
    drawn = [line.replace(empty, " ") for line in lines]
    assert drawn[0].strip() == ""  # room to jump
    assert drawn[-1].strip()
    widths = [len(line.strip()) for line in drawn]
    assert max(widths) > 3 > widths[-1]
    assert fine or all(line.isascii() for line in lines)


@pytest.mark.parametrize("fine", [True, False])
def test_missing_and_distant_joints_are_left_out(fine):
    positions = STANDING.copy()
    positions[3] = np.nan
    positions[2] = 1e6
    assert len(figure(positions, SKELETON, fine=fine)) == ROWS
    assert len(figure(np.full((4, 3), np.nan), SKELETON, fine=fine)) == ROWS
