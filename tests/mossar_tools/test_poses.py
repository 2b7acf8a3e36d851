"""Figures of poses: lines and dots on the side that the legend says."""

import numpy as np

from mossar_stream import Skeleton
from mossar_tools.palette import LIGHT
from mossar_tools.poses import draw_body
from mossar_tools.stick_figures import sides


def test_dots_have_the_colours_of_the_legend():
    drawn = []

    class Axes:
        def plot(self, x, _y, *_marks, color, **_style):
            drawn.append((color, len(x)))

    palette = LIGHT
    markers = Skeleton(("LASI", "RASI", "LKNE", "RKNE", "C7"), root=-1)
    draw_body(Axes(), markers, np.arange(5.0), np.arange(5.0), palette)
    assert dict(drawn) == {palette.left: 2, palette.right: 2, palette.ink: 1}


def test_bones_of_any_program_have_sides():
    assert sides(Skeleton(("下半身", "左腕", "右腕", "左足", "右足"))).tolist() == [0, 1, -1, 1, -1]
