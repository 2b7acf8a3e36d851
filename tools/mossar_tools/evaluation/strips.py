"""Strips: one picture with a strip per recording: the velocity curve, the truth, every method's key frames."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from mossar_stream import Settings, segment_recording
from mossar_tools.evaluation.matching import match
from mossar_tools.evaluation.mossar import at_level_of
from mossar_tools.evaluation.takes import Take
from mossar_tools.evaluation.trial import Outcome, Row
from mossar_tools.figures import FONT, save, style
from mossar_tools.palette import Palette

MOST = 6  # recordings of a group in a picture
WIDTH = 13.0  # inches
CURVE, LINE, GAP = 0.75, 0.15, 0.42  # inches: the curve, a method's line, between strips
LEFT, RIGHT, TOP, BOTTOM = 2.75, 0.6, 0.75, 0.45  # inches
MOST_POINTS = 3000  # of a curve


def draw_strips(
    path: Path,
    groups: Mapping[str, Sequence[Take]],
    rows: Mapping[str, Sequence[Row]],
    settings: Settings,
    palette: Palette,
) -> int:
    """Draw the strips of up to `MOST` recordings of each group, evenly chosen.

    Args:
        path: `.png`, `.svg` or `.pdf`.
        groups: Takes by group.
        rows: The scores, by group.
        settings: For the curve.
        palette: Colours.

    Returns:
        Number of recordings left out.
    """
    shown = [(name, i) for name, takes in groups.items() for i in chosen_of(len(takes))]
    heights = [CURVE + LINE * (len(rows[name]) + 0.5) for name, _ in shown]
    height = TOP + BOTTOM + sum(heights) + GAP * (len(shown) - 1)
    with mpl.rc_context(style(palette)):
        figure = Figure(figsize=(WIDTH, height))
        top = height - TOP
        for (name, i), own in zip(shown, heights, strict=True):
            box = (LEFT / WIDTH, (top - own) / height, (WIDTH - LEFT - RIGHT) / WIDTH, own / height)
            axes = figure.add_axes(box)
            outcomes = [(row, row.outcomes[i]) for row in rows[name]]
            _draw_strip(axes, groups[name][i], outcomes, own, settings, palette)
            top -= own + GAP
        _draw_legend(figure, height, palette)
        save(figure, path)
    return sum(len(takes) for takes in groups.values()) - len(shown)


def chosen_of(count: int) -> list[int]:
    """Return the indices of the shown recordings among `count`."""
    return sorted({int(i) for i in np.linspace(0, count - 1, min(count, MOST)).round()})


def _draw_strip(
    axes: Any,
    take: Take,
    outcomes: Sequence[tuple[Row, Outcome]],
    height: float,
    settings: Settings,
    palette: Palette,
) -> None:
    """Draw one recording; lines go downwards from 0, the curve stands on 0, in units of lines."""
    axes.set_xlim(float(take.times[0]), float(take.times[-1]))
    curve = CURVE / LINE
    axes.set_ylim(curve - height / LINE, curve)
    for cut in take.cuts:
        axes.axvspan(cut.earliest - take.tolerance, cut.latest + take.tolerance, color=palette.faint, lw=0)
        axes.axvline(cut.middle, color=palette.truth, lw=1.1)
    times, values = _curve(take, settings)
    axes.plot(times, values * (curve - 0.3), color=palette.resting, lw=0.9)
    axes.axhline(0, color=palette.muted, lw=0.5)
    for line, (row, outcome) in enumerate(outcomes):
        _draw_method(axes, -line - 0.75, take, row, outcome, palette)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.set_title(f"{take.name}", loc="left", pad=3)


def _curve(take: Take, settings: Settings) -> tuple[Any, Any]:
    chosen = at_level_of(take, settings.replace(similarity="likelihood")).replace(range="file")
    curves = segment_recording(
        take.positions, take.fps, take.skeleton, chosen, times=take.times, curves=True
    ).curves
    step = max(1, len(curves) // MOST_POINTS)
    return np.array([c.time for c in curves[::step]]), np.array([min(c.value, 1.0) for c in curves[::step]])


def _draw_method(axes: Any, y: float, take: Take, row: Row, outcome: Outcome, palette: Palette) -> None:
    """Draw a method's key frames, hits filled, with its name and F1 beside them."""
    found = outcome.found.times
    hits = {hit.found for hit in match(found, take.cuts, take.tolerance)}
    for hit, colour in ((True, palette.onset), (False, palette.level)):
        own = [time for i, time in enumerate(found) if (i in hits) == hit]
        marker, size = ("|", 7) if hit else ("x", 3.2)
        axes.plot(own, [y] * len(own), marker, ms=size, mew=1.6 if hit else 0.9, color=colour, clip_on=False)
    name = row.method if row.choice == "fixed" else f"{row.method}, {row.choice}"
    side = axes.get_yaxis_transform()
    axes.text(-0.008, y, name, transform=side, ha="right", va="center", fontsize=FONT - 2)
    scores = f"{outcome.scores.f1:.2f}"
    axes.text(1.008, y, scores, transform=side, va="center", fontsize=FONT - 2, color=palette.muted)


def _draw_legend(figure: Any, height: float, palette: Palette) -> None:
    handles = [
        Line2D([], [], color=palette.truth, lw=1.1, label="true cut"),
        Patch(color=palette.faint, label="what counts as a hit"),
        Line2D([], [], color=palette.resting, lw=0.9, label="velocity (share of range)"),
        Line2D([], [], color=palette.onset, marker="|", ms=8, mew=1.6, ls="", label="key frame, hits"),
        Line2D([], [], color=palette.level, marker="x", ms=4, ls="", label="key frame, misses"),
    ]
    figure.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(LEFT / WIDTH, 1 - 0.08 / height), ncols=5
    )
    figure.text(1 - 0.1 / WIDTH, 1 - 0.25 / height, "F1", ha="right", color=palette.muted)
    figure.text(0.5, 0.1 / height, "time (s)", ha="center")
