"""Framing: where the camera stands, so that the performer of now is in the picture on any screen.

The chart covers a part of the picture: below, but above on phones, where the controls come up from below. The scene
fills the rest. Where a row of ghosts would become too small, the oldest fall off the left edge.
"""

import math

from mossar_tools.dashboard.asking import asking
from mossar_tools.dashboard.style import OVERVIEW, PANEL, PHONE, SHEET, STRIP

FIELD = math.radians(36)  # of view, from top to bottom
FRONT = 1.0  # m by which the live body stands nearer than its ghosts
PITCH = math.atan(0.215)  # by which the camera looks down
_TALL = 2.7  # m that should be seen from top to bottom: a body, raised arms, and words below
_MIDDLE = 0.72  # m, height of the middle of that
_SMALLEST = 0.8  # share of the possible height under which ghosts are given up instead

Point = tuple[float, float, float]
Size = tuple[int, int]
USUAL = (1440, 800)


def size_teller() -> str:
    """Return HTML that reports the size of its window, which viser knows in pixels of the graphics card only.

    It also gives the page its name, for which viser has no option.
    """
    tell = asking("mossar/window", "innerWidth+'x'+innerHeight")
    return f'<img alt="" hidden="" src="data:," onerror="document.title=\'mossar\';const f=()=>{tell};f();window.onresize=f"/>'


def window_of(picture: Size, windows: list[Size]) -> Size:
    """Return the window that a picture is in, the one whose shape fits; the latest of several that do.

    Args:
        picture: Its width and height in any unit.
        windows: Those known, in px, the latest last.

    Example:
        >>> window_of((195, 400), [(390, 800), (1280, 800)])
        (390, 800)
    """
    shape = math.log(max(picture[0], 1) / max(picture[1], 1))
    return min(
        reversed([USUAL, *windows]),
        key=lambda window: round(abs(shape - math.log(_across(window) / max(window[1], 1))), 2),
    )


def _across(window: Size) -> int:
    """Return the width of the picture in a window, px."""
    return max(window[0] - PANEL if window[0] >= PHONE else window[0], 1)


def framed(window: Size, width: float, needed: float, *, whole_take: bool) -> tuple[Point, Point]:
    """Return the place of the camera and the point that it looks at.

    Args:
        window: Its width and height, px.
        width: Of the scene, m, its middle at 0; the most important part is at the right end.
        needed: So much of the right end must be seen, m.
        whole_take: Whether the overview of the whole take is shown, too.
    """
    across, down = _across(window), max(window[1], 1)
    chart = STRIP + (OVERVIEW if whole_take else 0)
    top, bottom = (chart, down * (1 - SHEET)) if window[0] < PHONE else (0.0, float(down - chart))
    free = max(bottom - top, 0.2 * down)
    upright = free / _TALL  # px for a metre, where the height decides
    scale = min(upright, max(across / width, min(_SMALLEST * upright, across / needed)))
    away = down / (2 * scale * math.tan(FIELD / 2))
    nearer = away / (away - min(FRONT, away / 2))  # by which things in front look larger
    middle = max(0.0, width / 2 - across / (2 * scale * nearer))
    low = _MIDDLE - (down / 2 - (top + free / 2)) / scale
    position = (middle, -away * math.cos(PITCH), low + away * math.sin(PITCH))
    return position, (middle, 0.0, low)
