"""Overview: a whole recording on one line, and where in it the chart and the playhead are.

The line is drawn once for each level; the moving parts lie above it and are small.
"""

import numpy as np

from mossar_tools.dashboard.chart import clock, seeking
from mossar_tools.dashboard.style import OVERVIEW
from mossar_tools.marks import Chart
from mossar_tools.thinning import extremes, runs, strongest_apart

_COLUMNS = 700  # of the curve
_BARS = 400  # segments that can be told apart
_MARKS = 160  # key frames that can
_AXIS = 13  # px below
_BOX = 1000.0  # units across


def overview(charts: list[Chart], start: float, end: float) -> str:
    """Return the whole of a recording as HTML.

    Args:
        charts: Performers, one row each.
        start: Begin of the recording, s.
        end: End of it, s.
    """
    span = max(end - start, 1e-3)
    high = (OVERVIEW - _AXIS - 6) / max(len(charts), 1)
    rows = "".join(_row(chart, i * high, high, start, span) for i, chart in enumerate(charts))
    words = "".join(
        f'<text x="{100 * share:.0f}%" y="{OVERVIEW - 8}" text-anchor="{anchor}">'
        f"{clock(start + share * span)}</text>"
        for share, anchor in ((0.0, "start"), (0.5, "middle"), (1.0, "end"))
    )
    return (
        f'<div class="mossar m-whole" id="mossar-whole"><svg width="100%" height="{OVERVIEW - 4}" '
        f'{seeking(start, end)}><rect class="ground" width="100%" height="{OVERVIEW - 4}"/>{rows}{words}</svg></div>'
    )


def place(start: float, end: float, window: tuple[float, float], now: float) -> str:
    """Return the places of the chart and the playhead in the recording, as HTML to lie upon it.

    Args:
        start: Begin of the recording, s.
        end: End of it, s.
        window: From and to of the chart, s.
        now: The playhead, s.
    """
    scale = 100 / max(end - start, 1e-3)
    left, right, head = (scale * (time - start) for time in (*window, now))
    tall = OVERVIEW - _AXIS - 4
    return (
        f'<div class="mossar m-whole m-place"><svg width="100%" height="{OVERVIEW - 4}">'
        f'<rect class="window" x="{left:.2f}%" width="{max(right - left, 0.3):.2f}%" y="0" height="{tall}" rx="2"/>'
        f'<line class="head" x1="{head:.2f}%" x2="{head:.2f}%" y1="0" y2="{tall}"/></svg></div>'
    )


def _row(chart: Chart, top: float, high: float, start: float, span: float) -> str:
    """Return curve, segments and the strongest key frames, in a box that is stretched over the width."""
    scale = _BOX / span
    times, _, value = extremes(chart.curve.times, chart.curve.value, _COLUMNS)
    peak = max(float(np.nanmax(value, initial=0.0)), 0.05)
    curve = "L".join(
        f"{scale * (time - start):.1f} {70 * (1 - v / peak):.0f}"
        for time, v in zip(times, np.nan_to_num(value), strict=True)
    )
    bars = "".join(
        f'<rect class="{part.state}" x="{scale * (part.start - start):.1f}" '
        f'width="{max(scale * (part.end - part.start), 0.1):.1f}" y="74" height="26"/>'
        for part in runs(chart.stretches, _BARS)
    )
    marks = "".join(
        f'<line class="stem {key.kind}" x1="{x:.1f}" x2="{x:.1f}" y1="0" y2="74"/>'
        for key in strongest_apart(chart.kept, span / _MARKS)
        for x in [scale * (key.time - start)]
    )
    area = f'<path class="whole" d="M0 70L{curve}L{_BOX:.0f} 70Z"/>' if len(times) else ""
    return (
        f'<svg class="box" x="0" y="{top:.1f}" width="100%" height="{high:.1f}" viewBox="0 0 {_BOX:.0f} 100" '
        f'preserveAspectRatio="none">{area}{marks}{bars}</svg>'
    )
