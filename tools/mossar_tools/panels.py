"""Panels of a plot: the velocity curve, the segments, the tree. Each returns the marks that it left out."""

import itertools
from typing import Any

import numpy as np

from mossar_tools.dendrogram import Merge, merges
from mossar_tools.excerpt import Excerpt
from mossar_tools.figures import FONT
from mossar_tools.marks import Stretch
from mossar_tools.palette import Palette
from mossar_tools.thinning import extremes, runs, strongest_apart

MARKS = {"onset": "^", "offset": "v", "minimum": "o"}
# Least distinguishable distances, inches.
MARK_GAP = 0.075  # between two marks on the curve
JOIN_GAP = 0.06  # between two joins of the tree
CUT_GAP = 0.035
COUNT_GAP = 0.16  # a number
LETTER, NAME_GAP = 0.075, 0.15  # of a name, between names
BAR = 0.025  # a segment
_GOLDEN = 0.6180339887  # multiples of it fill 0..1 evenly
_POINTS = 160  # of the curve, an inch

LeftOut = list[str]


def draw_curve(axes: Any, shown: Excerpt, width: float, palette: Palette) -> LeftOut:
    """Draw velocity, envelope and threshold, and the key frames by kind.

    Args:
        axes: Of the panel.
        shown: The excerpt.
        width: Of the panel, inches.
        palette: Colours.
    """
    gap = (shown.end - shown.start) / width
    kept = strongest_apart(shown.kept, MARK_GAP * gap)
    merged = strongest_apart(shown.merged, MARK_GAP * gap, taken=[key.time for key in shown.kept])
    _draw_envelope(axes, shown, int(width * _POINTS), palette)
    colours = {kind: getattr(palette, kind) for kind in MARKS}
    for kind, mark in MARKS.items():
        found = [key for key in merged if key.kind == kind]
        axes.plot(
            [key.time for key in found],
            [shown.height(key) for key in found],
            mark,
            ms=4.5,
            mfc=palette.background,
            mec=colours[kind],
            mew=1.0,
            label=kind if any(key.kind == kind for key in shown.marks) else None,
            zorder=4,
        )
    for key in kept:
        axes.plot(key.time, shown.height(key), MARKS[key.kind], ms=5, color=colours[key.kind], zorder=5)
    for key in kept:
        axes.axvline(key.time, ymax=1.02, color=colours[key.kind], lw=0.9, zorder=1, clip_on=False)
    return [
        *_said(len(kept), len(shown.kept), "marks of kept key frames"),
        *_said(len(merged), len(shown.merged), "marks of merged ones"),
    ]


def _draw_envelope(axes: Any, shown: Excerpt, most: int, palette: Palette) -> None:
    curve, top = shown.curve, shown.top
    axes.set_ylim(0, top)
    axes.set_ylabel("velocity (share of range)")
    times, low, _ = extremes(curve.times, curve.floor, most)
    high = extremes(curve.times, curve.ceiling, most)[2]
    band = {"color": palette.faint, "lw": 0, "label": "floor to ceiling"}
    axes.fill_between(times, np.clip(low, 0, top), np.clip(high, 0, top), **band)
    times, low, high = extremes(curve.times, curve.value, most)
    if low is not high:  # more frames than can be told apart: from the lowest to the highest of each stretch
        axes.fill_between(times, low, high, color=palette.ink, lw=0.3)
    axes.plot(times, high, color=palette.ink, lw=0.9 if low is high else 0.3, label="velocity")
    axes.axhline(shown.threshold, color=palette.muted, lw=0.8, ls=(0, (4, 3)), label="threshold")


def draw_segments(axes: Any, shown: Excerpt, width: float, palette: Palette) -> LeftOut:
    """Draw the segments coloured by state, and true cuts where they are known; as `draw_curve`."""
    said = draw_strip(axes, "segments", shown.stretches, shown, width, palette)
    said += _draw_repetitions(axes, shown, width, palette)
    said += _draw_moves(axes, shown, width, palette)
    if len(shown.cuts) > width / CUT_GAP:
        return [*said, f"{len(shown.cuts)} true cuts, too near to one another"]
    axes.vlines(shown.cuts, -0.15, 1.15, color=palette.truth, lw=1.6, clip_on=False, zorder=5)
    return said


def _draw_repetitions(axes: Any, shown: Excerpt, width: float, palette: Palette) -> LeftOut:
    """Draw where repetitions begin and end, and their number in the bout."""
    gap = (shown.end - shown.start) / width
    if not shown.repetitions:
        return []
    edges = sorted({time for start, end, _ in shown.repetitions for time in (start, end)})
    axes.vlines(edges, 0.08, 0.92, color=palette.ink, lw=0.8, ls=(0, (2, 2)), zorder=4)
    if min(end - start for start, end, _ in shown.repetitions) < COUNT_GAP * gap:
        return ["the numbers of repetitions"]
    for start, end, count in shown.repetitions:
        axes.text((start + end) / 2, 0.5, str(count), ha="center", va="center", fontsize=FONT - 1, zorder=6)
    return []


def _draw_moves(axes: Any, shown: Excerpt, width: float, palette: Palette) -> LeftOut:
    """Draw from when to when moves last, and their names where there is room."""
    if not shown.moves:
        return []
    for move in shown.moves:
        axes.hlines(0.08, move.start, move.end, color=palette.level, lw=2.5, zorder=6)
    gap = (shown.end - shown.start) / width
    middles = [(move.start + move.end) / 2 for move in shown.moves]
    widths = [LETTER * len(move.name) + NAME_GAP for move in shown.moves]
    rooms = zip(itertools.pairwise(middles), itertools.pairwise(widths), strict=True)
    if any(after - before < (own + other) / 2 * gap for (before, after), (own, other) in rooms):
        return ["the names of moves"]
    for middle, move in zip(middles, shown.moves, strict=True):
        box = {"facecolor": palette.background, "alpha": 0.8, "lw": 0, "pad": 1.0}
        axes.text(middle, 0.5, move.name, ha="center", va="center", fontsize=FONT - 1, zorder=6, bbox=box)
    return []


def draw_strip(
    axes: Any, name: str, segments: list[Stretch], shown: Excerpt, width: float, palette: Palette
) -> LeftOut:
    """Draw segments coloured by state, of the body or of a limb.

    Args:
        axes: Where.
        name: Stands on the left.
        segments: Which.
        shown: From when to when.
        width: Of the panel, inches.
        palette: Colours.
    """
    axes.set_ylim(0, 1)
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(False)
    most = int(width / BAR)
    parts = runs(segments, most)
    colours = {"moving": palette.moving, "resting": palette.resting}
    # Between two bars, but never more than a quarter of one.
    space = 0.02 * (shown.end - shown.start) / width if len(segments) <= most else 0.0
    widths = [part.end - part.start for part in parts]
    bars = [(p.start, max(w - min(space, w / 4), 1e-9)) for p, w in zip(parts, widths, strict=True)]
    axes.broken_barh(bars, (0.08, 0.84), facecolors=[colours[part.state] for part in parts], lw=0)
    label = name.replace("_", " ")
    axes.text(-0.006, 0.5, label, transform=axes.transAxes, ha="right", va="center")
    return [f"{len(segments)} {label} by the state of most of the time"] if len(segments) > most else []


def draw_tree(axes: Any, shown: Excerpt, width: float, palette: Palette) -> LeftOut:
    """Draw the hierarchy; below the level each segment in the colour of its state; as `draw_curve`."""
    axes.set_yscale("function", functions=(_root, _square))
    axes.set_ylabel("strength")
    found = [
        merge
        for merge in merges(shown.hierarchy, *shown.whole)
        if merge.right >= shown.start and merge.left <= shown.end
    ]
    joins = _strongest(found, max(1, int(width / JOIN_GAP)))
    highest = max((merge.height for merge in joins), default=1.0)
    axes.set_ylim(0, max(highest, shown.level) * 1.15 + 1e-9)
    axes.set_yticks(ticks := _ticks(axes.get_ylim()[1]), [f"{tick:g}" for tick in ticks])
    _draw_joins(axes, joins, shown, palette)
    axes.axhline(shown.level, color=palette.level, lw=1.1, ls=(0, (5, 2)))
    axes.text(
        1.005,
        shown.level,
        shown.level_name,
        color=palette.level,
        transform=axes.get_yaxis_transform(),
        va="center",
        fontsize=FONT - 1,
    )
    return _said(len(joins), len(found), "joins of the tree")


def _strongest(found: list[Merge], most: int) -> list[Merge]:
    """Return the highest joins; of those about as high, as in a motion repeated, some from everywhere."""
    order = sorted(range(len(found)), key=lambda i: (-round(found[i].height, 1), i * _GOLDEN % 1.0))
    return [found[i] for i in sorted(order[:most])]


def _draw_joins(axes: Any, joins: list[Merge], shown: Excerpt, palette: Palette) -> None:
    from matplotlib.collections import LineCollection

    colour = _Colours(shown, palette)
    lines: list[Any] = []
    colours: list[str] = []
    widths: list[float] = []
    for merge in joins:
        low = colour.at((merge.start + merge.end) / 2)
        lines.append([(merge.left, merge.height), (merge.right, merge.height)])
        colours.append(palette.muted if merge.height >= shown.level else low)
        widths.append(1.2)
        for place, foot in ((merge.left, merge.left_height), (merge.right, merge.right_height)):
            knee = min(max(shown.level, foot), merge.height)
            lines += [[(place, foot), (place, knee)], [(place, knee), (place, merge.height)]]
            colours += [colour.at(place), palette.muted]
            widths += [1.5, 1.0]
    axes.add_collection(LineCollection(lines, colors=colours, linewidths=widths, capstyle="projecting"))


class _Colours:
    """The colour of the segment at a time."""

    def __init__(self, shown: Excerpt, palette: Palette) -> None:
        self._ends = np.array([part.end for part in shown.stretches])
        self._parts = shown.stretches
        self._palette = palette

    def at(self, time: float) -> str:
        i = int(np.searchsorted(self._ends, time))
        if i == len(self._parts) or self._parts[i].start > time:
            return self._palette.muted
        return self._palette.moving if self._parts[i].state == "moving" else self._palette.resting


def _said(drawn: int, there: int, what: str) -> LeftOut:
    return [f"{there - drawn} of {there} {what}"] if drawn < there else []


def _ticks(top: float) -> list[float]:
    """Return round strengths up to the top that lie well apart on the axis, which is drawn by square roots."""
    chosen = [0.0]
    for tick in (0.1, 0.25, 0.5, 1, 2, 4, 8, 16, 32, 64):
        if tick <= top and tick**0.5 - chosen[-1] ** 0.5 > 0.07 * top**0.5:
            chosen.append(tick)
    return chosen


def _root(values: Any) -> Any:
    return np.sqrt(np.maximum(values, 0))


def _square(values: Any) -> Any:
    return np.square(values)
