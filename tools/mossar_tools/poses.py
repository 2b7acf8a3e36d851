"""Poses: stick figures at the strongest key frames, side by side above a curve and tied to their times."""

from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np

from mossar_adapters.files.loaded import LoadedRecording
from mossar_stream import Skeleton
from mossar_tools.excerpt import Excerpt
from mossar_tools.marks import Mark
from mossar_tools.palette import Palette
from mossar_tools.stick_figures import Floats, head_of, project, sides, view_of
from mossar_tools.thinning import strongest_apart

NARROWEST = 0.65  # inches for a figure
MARGIN = 0.08  # inches between two
LOW, HIGH = -0.3, 1.1  # of the panel, in heights of the tallest figure


class _Figure(msgspec.Struct, frozen=True):
    key: Mark
    joints: Floats  # (J, 2) m, above the lowest joint

    @property
    def height(self) -> float:
        return float(np.nanmax(self.joints[:, 1]))

    @property
    def reach(self) -> float:
        """Its extent to either side of its place, m."""
        return float(np.nanmax(np.abs(self.joints[:, 0])))


def draw_poses(
    axes: Any, whole: LoadedRecording, shown: Excerpt, size: tuple[float, float], palette: Palette
) -> list[str]:
    """Draw the figures and return the ones that were left out.

    Args:
        axes: Where.
        whole: The recording.
        shown: The excerpt.
        size: Width and height of the panel, inches.
        palette: Colours.
    """
    axes.set_axis_off()
    axes.set_ylim(LOW, HIGH)
    width, height = size
    span = shown.end - shown.start
    most = max(1, int(width / NARROWEST))
    view = view_of(whole.skeleton, whole.positions[:: max(1, len(whole.positions) // 200)].astype(np.float64))
    candidates = _figures(whole, _chosen(shown.kept, most, span), view)
    if not candidates:
        return []
    # As tall as the tallest, so that a raised arm or club stays within the panel; a metre is as long across.
    tallest = max(view.height, *(figure.height for figure in candidates))
    inches = height / (HIGH - LOW) / tallest  # of a metre
    reach = float(np.quantile([figure.reach for figure in candidates], 0.8))
    gap = max(NARROWEST, 2 * reach * inches + MARGIN)
    most = min(most, max(1, int(width / gap)))
    figures = _figures(whole, _chosen(shown.kept, most, span), view)
    times = [figure.key.time for figure in figures]
    places = spread(times, shown.start, shown.end, min(gap, width / len(figures)) * span / width)
    for figure, place in zip(figures, places, strict=True):
        x = place + figure.joints[:, 0] * inches * span / width
        draw_body(axes, whole.skeleton, x, figure.joints[:, 1] / tallest, palette)
        tie = [place, place, figure.key.time, figure.key.time]
        axes.plot(tie, [-0.06, -0.11, -0.25, -0.37], color=palette.muted, lw=0.6, clip_on=False)
    missing = len(shown.kept) - len(figures)
    return [f"{missing} of {len(shown.kept)} poses"] if missing else []


def _chosen(keys: Sequence[Mark], most: int, span: float) -> Sequence[Mark]:
    """Return all key frames if there is room, else the strongest that lie well apart."""
    if len(keys) <= most:
        return keys
    gap = 0.5 * span / most
    while len(chosen := strongest_apart(keys, gap)) > most:
        gap *= 1.1
    return chosen


def _figures(whole: LoadedRecording, keys: Sequence[Mark], view: Any) -> list[_Figure]:
    found = []
    for key in keys:
        flat = project(whole.positions[key.frame].astype(np.float64), view)
        if np.isfinite(flat).any():
            flat[:, 1] -= np.nanmin(flat[:, 1])
            found.append(_Figure(key, flat))
    return found


def draw_body(axes: Any, skeleton: Skeleton, x: Any, y: Any, palette: Palette) -> None:
    """Draw a pose whose joints lie at x, y."""
    side = sides(skeleton)
    colours = {1: palette.left, -1: palette.right, 0: palette.ink}
    for parent, child in skeleton.bones():
        where = side[child] if side[child] == side[parent] or side[parent] == 0 else 0
        bone = [parent, child]
        axes.plot(x[bone], y[bone], color=colours[where], lw=1.8, solid_capstyle="round", clip_on=False)
    head = head_of(skeleton)
    if head >= 0:
        axes.plot(x[head], y[head], "o", ms=5.5, color=palette.ink, clip_on=False)
    if not skeleton.bones():
        for own, colour in colours.items():
            axes.plot(x[side == own], y[side == own], "o", ms=2.0, color=colour, clip_on=False)


def spread(times: Sequence[float], low: float, high: float, gap: float) -> list[float]:
    """Return places as near as can be to `times` that lie `gap` apart, in the same order, within low..high.

    Args:
        times: In ascending order.
        low: Where the space begins.
        high: Where it ends.
        gap: Between two places; there must be room for all of them.

    Example:
        >>> spread([5.0, 5.1], 0.0, 10.0, 1.0)
        [4.55, 5.55]
    """
    # Clusters of neighbours that touch are centred on the mean of their times, and joined while they overlap.
    clusters: list[list[float]] = []  # [sum of (time - rank * gap), count]
    for time in times:
        clusters.append([time, 1])
        while len(clusters) > 1:
            (sum_a, n_a), (sum_b, n_b) = clusters[-2:]
            if sum_a / n_a + n_a * gap <= sum_b / n_b:
                break
            clusters[-2:] = [[sum_a + sum_b - n_b * n_a * gap, n_a + n_b]]
    places = [total / n + rank * gap for total, n in clusters for rank in range(int(n))]
    for i in range(len(places)):
        places[i] = max(places[i], low + gap / 2 + i * gap)
    for i in range(len(places)):
        places[-1 - i] = min(places[-1 - i], high - gap / 2 - i * gap)
    return [round(place, 9) for place in places]
