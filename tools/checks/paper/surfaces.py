"""Surfaces: Figures 11 to 14 of the paper, on our recordings, as one picture."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from checks.paper.grid import Axis, Grid
from checks.paper.tables import mean_perf, total_seconds
from mossar_tools.figures import save, style
from mossar_tools.palette import Palette

COLUMNS = 4
CELL = 3.3, 2.9  # inches
COLOURS = "cividis"  # reads the same with any kind of colour vision
_MARKS = "osD^v"


def draw_surfaces(path: Path, splitting: Sequence[Grid], remerging: Sequence[Grid], palette: Palette) -> None:
    """Draw Perf over the thresholds (Figs. 11 to 13) and against time (Fig. 14).

    Args:
        path: `.png`, `.svg` or `.pdf`.
        splitting: Velocity-based method and splitting, by group.
        remerging: Li and Leung's method and Mossar, by group.
        palette: Colours.
    """
    panels = [(f"Fig. 11: {g.method}, {g.group}", g.first, g.second, g.perf()) for g in splitting]
    panels += [(f"Fig. 12: {g.method}, {g.group}", g.first, g.second, g.perf()) for g in remerging]
    axes = remerging[0].first, remerging[0].second
    panels += [(f"Fig. 13: {name}, mean", *axes, perf) for name, perf in mean_perf(remerging).items()]
    rows = math.ceil((len(panels) + 1) / COLUMNS)
    with mpl.rc_context(style(palette)):
        figure = Figure(figsize=(CELL[0] * COLUMNS, CELL[1] * rows), layout="constrained")
        for place, panel in enumerate(panels, 1):
            _draw_surface(figure.add_subplot(rows, COLUMNS, place, projection="3d"), *panel, palette)
        _draw_times(figure.add_subplot(rows, COLUMNS, len(panels) + 1), remerging, palette)
        save(figure, path)


def _draw_surface(
    axes: Any, title: str, first: Axis, second: Axis, perf: NDArray[np.float64], palette: Palette
) -> None:
    x, y = np.meshgrid(range(len(second.values)), range(len(first.values)))
    axes.plot_surface(
        x, y, perf, cmap=COLOURS, vmin=0, vmax=1, edgecolor=palette.muted, lw=0.2, rstride=1, cstride=1
    )
    axes.set_zlim(0, 1)
    for axis, name in ((second, "x"), (first, "y")):
        ticks = sorted({int(i) for i in np.linspace(0, len(axis.values) - 1, min(4, len(axis.values)))})
        getattr(axes, f"set_{name}ticks")(ticks, [f"{axis.values[i]:g}" for i in ticks])
        getattr(axes, f"set_{name}label")(
            f"{axis.name} ({axis.unit})" if axis.unit else axis.name, labelpad=-2
        )
    axes.tick_params(pad=-2)
    axes.set_zlabel("Perf", labelpad=-4)
    axes.set_title(title)
    for side in (axes.xaxis, axes.yaxis, axes.zaxis):
        side.set_pane_color(palette.background)
        side._axinfo["grid"]["color"] = palette.faint  # noqa: SLF001 - matplotlib has no other way
    axes.view_init(elev=28, azim=-125)


def _draw_times(axes: Any, grids: Sequence[Grid], palette: Palette) -> None:
    """Draw Fig. 14: one mark for each N and L."""
    colours = (palette.level, palette.onset, palette.minimum, palette.offset, palette.moving)
    seconds = total_seconds(grids)
    for i, (name, perf) in enumerate(mean_perf(grids).items()):
        mark = _MARKS[i % len(_MARKS)]
        axes.plot(
            seconds[name].ravel(), perf.ravel(), mark, ms=4, color=colours[i % len(colours)], label=name
        )
    axes.set_xscale("log")
    axes.set_ylim(0, 1)
    axes.set_xlabel("time for all recordings (s)")
    axes.set_ylabel("Perf, mean over the groups")
    axes.set_title("Fig. 14: Perf against time")
    axes.legend(loc="lower right")
