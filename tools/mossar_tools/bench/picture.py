"""Picture: the measurements as bars, one panel for each part."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter, MaxNLocator

from mossar_tools.bench.measurement import Measurement
from mossar_tools.bench.measures import Measures
from mossar_tools.figures import save, style
from mossar_tools.palette import Palette

COLUMNS = 2
WIDTH, LINE, FRAME = 6.4, 0.22, 1.0  # inches: of a panel, of a bar, around the bars
WIDE = 30.0  # ratio of values in a panel from which the axis is logarithmic


def draw(path: Path, rows: Sequence[Measurement], measures: Measures, about: str, palette: Palette) -> None:
    """Draw all measurements.

    Args:
        path: `.png`, `.svg` or `.pdf`.
        rows: Part by part.
        measures: Descriptions of the parts.
        about: The machine.
        palette: Colours.
    """
    kinds = dict.fromkeys((row.part, row.unit) for row in rows)
    panels = [[row for row in rows if (row.part, row.unit) == kind] for kind in kinds]
    lines = math.ceil(len(panels) / COLUMNS)
    heights = [
        FRAME + LINE * max(len(panel) for panel in panels[i * COLUMNS : (i + 1) * COLUMNS])
        for i in range(lines)
    ]
    with mpl.rc_context(style(palette)):
        figure = Figure(figsize=(WIDTH * min(COLUMNS, len(panels)), sum(heights) + 0.4), layout="constrained")
        figure.suptitle(about, color=palette.muted)
        grid = figure.add_gridspec(lines, min(COLUMNS, len(panels)), height_ratios=heights)
        for place, panel in enumerate(panels):
            axes = figure.add_subplot(grid[place // COLUMNS, place % COLUMNS])
            _draw_panel(axes, panel, measures[panel[0].part].title, palette)
        save(figure, path)


def _draw_panel(axes: Any, rows: Sequence[Measurement], title: str, palette: Palette) -> None:
    places = range(len(rows))
    values = [row.value for row in rows]
    axes.barh(places, values, color=palette.resting, height=0.7)
    for place, row in zip(places, rows, strict=True):
        axes.plot([min(row.values), max(row.values)], [place, place], color=palette.ink, lw=1)
        if row.target is not None:
            limit = row.target.limit
            axes.plot([limit, limit], [place - 0.4, place + 0.4], color=palette.level, lw=2)
    positive = [value for value in values if value > 0]
    if positive and max(positive) > WIDE * min(positive):
        axes.set_xscale("log")
    else:
        axes.set_xlim(left=0)
        axes.xaxis.set_major_locator(MaxNLocator(5))
        axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    axes.set_yticks(list(places), [row.name for row in rows])
    axes.invert_yaxis()
    axes.set_xlabel(rows[0].unit)
    axes.set_title(title.partition(":")[0].partition(",")[0], loc="left")
