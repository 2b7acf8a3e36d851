"""Picture: F1 against throughput."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from checks.peers import ours
from checks.peers.results import Result
from mossar_tools.figures import save, style
from mossar_tools.palette import Palette

PANEL = 5.2, 3.6  # inches


def draw(path: Path, rows: Sequence[Result], palette: Palette) -> None:
    """Draw a panel for each group: to the right is quicker, up is more accurate.

    Args:
        path: `.png`, `.svg` or `.pdf`.
        rows: The standings.
        palette: Colours.
    """
    groups = list(dict.fromkeys(row.group for row in rows))
    with mpl.rc_context(style(palette)):
        figure = Figure(figsize=(PANEL[0] * len(groups), PANEL[1]), layout="constrained")
        for place, group in enumerate(groups, 1):
            axes = figure.add_subplot(1, len(groups), place)
            own = sorted((row for row in rows if row.group == group), key=lambda row: row.rate)
            for number, row in enumerate(own):
                colour = palette.level if row.name.startswith(ours.NAME) else palette.minimum
                axes.plot(row.rate, row.f1, "o", color=colour, mfc="none" if row.knows else colour)
                label = f" {row.name}{'*' if row.knows else ''} "
                # Neighbours are named on different sides, so that the names do not cover each other.
                side: Any = {"ha": ("right", "left")[number % 2], "va": ("bottom", "top")[number % 2]}
                axes.annotate(label, (row.rate, row.f1), fontsize=6.5, **side)
            axes.set_xscale("log")
            axes.margins(x=0.45)
            axes.set_ylim(0, 1.05)
            axes.set_xlabel("frames/s")
            axes.set_ylabel("F1")
            axes.set_title(group, loc="left")
        save(figure, path)
