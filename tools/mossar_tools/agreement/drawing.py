"""A picture of agreement: the labels of each labeller, the distances of boundaries, the confusion of names."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from mossar_adapters.annotations.tiers import Tier
from mossar_tools.agreement.measures import NOTHING, Agreement
from mossar_tools.figures import save, style
from mossar_tools.palette import Palette

WIDTH = 11.0  # inches
MOST = 8  # recordings that are drawn
MOST_NAMES = 12  # of a confusion; the rest is left out
# Okabe and Ito's colours, distinct with any kind of colour vision.
COLOURS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442", "#999999")


def draw_agreement(
    path: Path,
    labellers: Sequence[str],
    tiers: Mapping[str, Sequence[Tier]],
    whole: Agreement,
    palette: Palette,
) -> None:
    """Draw the labels of up to `MOST` recordings, and offsets and confusion of the first two labellers.

    Args:
        path: `.png`, `.svg` or `.pdf`.
        labellers: Names.
        tiers: By recording, one for each labeller.
        whole: Of the first two labellers, over all recordings.
        palette: Colours.

    Raises:
        MossarError: If the file cannot be written.
    """
    shown = dict(list(tiers.items())[:MOST])
    names = sorted({mark.label for own in shown.values() for tier in own for mark in tier.marks})
    colours = {name: COLOURS[i % len(COLOURS)] for i, name in enumerate(names)}
    strip = 0.28 * len(labellers) + 0.5  # inches
    height = strip * len(shown) + 4.2
    with mpl.rc_context(style(palette)):
        figure = Figure(figsize=(WIDTH, height), layout="constrained")
        grid = figure.add_gridspec(len(shown) + 1, 2, height_ratios=[*[strip] * len(shown), 3.4])
        for row, (name, own) in enumerate(shown.items()):
            axes = figure.add_subplot(grid[row, :])
            _draw_strip(axes, name, labellers, own, colours, palette)
        _draw_offsets(figure.add_subplot(grid[-1, 0]), labellers, whole, palette)
        _draw_confusion(figure.add_subplot(grid[-1, 1]), labellers, whole, palette)
        save(figure, path)


def _draw_strip(
    axes: Any,
    name: str,
    labellers: Sequence[str],
    tiers: Sequence[Tier],
    colours: Mapping[str, str],
    palette: Palette,
) -> None:
    end = max((mark.end for tier in tiers for mark in tier.marks), default=1.0)
    for row, tier in enumerate(tiers):
        for mark in tier.marks:
            if tier.moments:
                axes.plot([mark.start] * 2, [row - 0.4, row + 0.4], color=colours[mark.label], linewidth=1.4)
                continue
            width = mark.end - mark.start
            axes.barh(
                row,
                width,
                left=mark.start,
                height=0.8,
                color=colours[mark.label],
                edgecolor=palette.background,
            )
            if width > 0.006 * end * (len(mark.label) + 2):
                axes.text(mark.start + width / 2, row, mark.label, ha="center", va="center", fontsize=6.5)
    axes.set(title=name, xlim=(0, end), ylim=(len(tiers) - 0.5, -0.5), yticks=range(len(tiers)))
    axes.set_yticklabels(labellers)
    axes.set_xlabel("s")


def _draw_offsets(axes: Any, labellers: Sequence[str], whole: Agreement, palette: Palette) -> None:
    offsets = 1000 * np.array(whole.offsets)
    if len(offsets):
        axes.hist(offsets, bins=min(40, max(8, len(offsets) // 3)), color=palette.minimum)
        axes.axvline(float(np.median(offsets)), color=palette.level, linewidth=1)
    axes.set(
        title=f"{len(offsets)} boundaries in common",
        xlabel=f"ms from {labellers[0]} to {labellers[1]}; the line is the median",
        ylabel="boundaries",
    )


def _draw_confusion(axes: Any, labellers: Sequence[str], whole: Agreement, palette: Palette) -> None:
    rows, columns = (_most_used(whole, of) for of in (0, 1))
    table = np.array([[whole.confusion.get((a, b), 0.0) for b in columns] for a in rows])
    shares = table / np.maximum(table.sum(axis=1, keepdims=True), 1e-12) if table.size else np.zeros((1, 1))
    axes.imshow(
        shares, cmap=mpl.colors.LinearSegmentedColormap.from_list("m", [palette.background, palette.minimum])
    )
    for i, j in np.ndindex(table.shape):
        if table[i, j]:
            colour = palette.background if shares[i, j] > 0.5 else palette.ink
            text = f"{table[i, j]:.0f}" if whole.moments else f"{table[i, j]:.1f}"
            axes.text(j, i, text, ha="center", va="center", fontsize=6.5, color=colour)
    axes.set_xticks(range(len(columns)), [name or "nothing" for name in columns], rotation=45, ha="right")
    axes.set_yticks(range(len(rows)), [name or "nothing" for name in rows])
    unit = "moments" if whole.moments else "seconds"
    axes.set(title=f"{unit}: {labellers[0]} down, {labellers[1]} across")


def _most_used(whole: Agreement, of: int) -> list[str]:
    totals: dict[str, float] = {}
    for names, value in whole.confusion.items():
        totals[names[of]] = totals.get(names[of], 0.0) + value
    most = sorted(totals, key=lambda name: -totals[name])[:MOST_NAMES]
    return sorted(most, key=lambda name: (name == NOTHING, name))
