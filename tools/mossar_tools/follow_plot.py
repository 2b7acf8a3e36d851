"""Follow plot: the deviation of each performance of a followed move, limb by limb, as small multiples."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mossar_stream import FollowEvent
from mossar_tools.figures import FONT, save, style
from mossar_tools.palette import Palette

MOST_MOVES, MOST_LIMBS = 8, 7  # rows and columns that can be told apart
ROW, HEAD, FOOT = 1.55, 0.62, 0.5  # inches
LEFT, RIGHT, GAP = 0.72, 0.2, 0.16
WHOLE = "body"


def draw_followed(
    path: Path, name: str, followed: Sequence[FollowEvent], palette: Palette, width: float
) -> None:
    """Draw the deviation of each performance that was done: a row for each move, a panel for the body and each limb.

    Args:
        path: `.png`, `.svg` or `.pdf`.
        name: Of the recording.
        followed: At least one; those of a move in their order.
        palette: Colours.
        width: Inches.

    Raises:
        MossarError: If the file cannot be written.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(event.name for event in followed))
    limbs = list(dict.fromkeys(limb for event in followed for limb in event.limbs))
    shown, columns = names[:MOST_MOVES], [WHOLE, *limbs[:MOST_LIMBS]]
    left_out = [f"{len(names) - len(shown)} moves"] * (len(names) > len(shown))
    left_out += [f"{len(limbs) - MOST_LIMBS} limbs"] * (len(limbs) > MOST_LIMBS)
    height = HEAD + ROW * len(shown) + FOOT
    with mpl.rc_context(style(palette)):
        figure = Figure(figsize=(width, height))
        panels = figure.subplots(len(shown), len(columns), sharey="row", squeeze=False)
        figure.subplots_adjust(
            left=LEFT / width,
            right=1 - RIGHT / width,
            top=1 - HEAD / height,
            bottom=FOOT / height,
            wspace=GAP,
            hspace=0.3,
        )
        for row, move in zip(panels, shown, strict=True):
            own = [event for event in followed if event.name == move]
            row[0].set_ylabel(f"{move}\ndeviation (degrees)")
            for axes, limb in zip(row, columns, strict=True):
                _draw_limb(axes, own, limb, palette)
        for axes, limb in zip(panels[0], columns, strict=True):
            axes.set_title(limb.replace("_", " "))
        panels[-1][0].set_xlabel("performance")
        figure.text(LEFT / width, 1 - 0.27 / height, Path(name).name, fontsize=11, weight="bold", va="center")
        said = f"{len(followed)} performances; coloured: the limb that strays most, line: median"
        said += f"; not drawn: {', '.join(left_out)}" if left_out else ""
        figure.text(1 - RIGHT / width, 1 - 0.27 / height, said, ha="right", va="center", color=palette.muted)
        save(figure, path)


def _draw_limb(axes: Any, own: list[FollowEvent], limb: str, palette: Palette) -> None:
    counts = np.array([event.count for event in own])
    angles = np.array([event.deviation if limb == WHOLE else event.limbs.get(limb, np.nan) for event in own])
    colours = [palette.level if event.limb == limb else palette.resting for event in own]
    axes.bar(counts, np.nan_to_num(angles), width=0.8, color=colours, lw=0)
    if np.isfinite(angles).any():
        middle = float(np.nanmedian(angles))
        axes.axhline(middle, color=palette.ink, lw=0.8)
        axes.text(0.99, 0.97, f"{middle:.0f}°", transform=axes.transAxes, ha="right", va="top", fontsize=FONT)
    axes.set_xlim(0.4, max(counts.max(), 2) + 0.6)
    axes.margins(y=0.25)
    axes.xaxis.get_major_locator().set_params(integer=True, nbins=5)
