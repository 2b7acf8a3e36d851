"""Chart: the velocity curve with its key frames, and the segments below, as one SVG that fills its width.

Horizontal places are shares of the width, so that the browser scales the drawing without asking again. Curves are
drawn in a box of 1000 units that is stretched; marks and words are placed in it unstretched.
"""

from collections.abc import Callable
from html import escape

import numpy as np
from numpy.typing import NDArray

from mossar_tools.dashboard.asking import asking
from mossar_tools.dashboard.glimpse import Glimpse
from mossar_tools.dashboard.style import STRIP
from mossar_tools.marks import Chart, Mark, NamedMove, Stretch

MOST_ROWS = 3  # performers with a chart of their own
_HEIGHT = STRIP - 36  # px of the drawing
_AXIS = 16  # px of the time axis
_STRIP = 20  # px of the segments
_GAP = 6  # px between curve and segments
_LIMB_STRIP = 9  # px of a limb's segments, with the gap above
_BOX = 1000.0  # units across

SYMBOLS = {
    "onset": "M0-5.2L5 4H-5Z",
    "offset": "M0 5.2L5-4H-5Z",
    "minimum": "M-4.4 0a4.4 4.4 0 1 0 8.8 0a4.4 4.4 0 1 0-8.8 0Z",
}


def chart(glimpses: list[Glimpse], *, seeks: bool = False) -> str:
    """Return the chart of a few performers as HTML.

    Args:
        glimpses: Performers.
        seeks: Whether a click goes to the time that it is at, as in a recording, with room for the whole take below.
    """
    above = " above" * seeks
    shown = glimpses[:MOST_ROWS]
    if not shown:
        return f'<div class="mossar m-strip{above}" id="mossar-chart"><p class="dim">Waiting for frames …</p></div>'
    marks = [mark for glimpse in shown for mark in glimpse.marks if not mark.tentative]
    kept = sum(mark.kept for mark in marks)
    head = (
        f'<div class="m-top"><span><b id="mossar-kept">{kept}</b> of '
        f'<b id="mossar-known">{len(marks)}</b> key frames in view stand</span>{_legend()}</div>'
    )
    height = (_HEIGHT - _AXIS) / len(shown)
    rows = [_row(g, i * height, height, named=len(glimpses) > 1, seeks=seeks) for i, g in enumerate(shown)]
    svg = "".join(rows) + _time_axis(shown[0], _HEIGHT - _AXIS)
    touch = seeking(shown[0].start, shown[0].end) if seeks else ""
    return (
        f'<div class="mossar m-strip{above}" id="mossar-chart">{head}'
        f'<svg class="plot" height="{_HEIGHT}" {touch}><rect class="ground" width="100%" height="{_HEIGHT}"/>'
        f"{svg}</svg></div>"
    )


def seeking(start: float, end: float) -> str:
    """Return attributes by which a touch on a picture from one time to another moves the playhead there.

    The picture is replaced many times a second, so a press counts instead of a click, which would need the same picture
    at its end.
    """
    place = (
        f"({start:.3f}+Math.min(1,Math.max(0,(event.clientX-b.left)/b.width))*{end - start:.3f}).toFixed(3)"
    )
    seek = f"const b=this.getBoundingClientRect();{asking('mossar/seek', place)}"
    return f'onpointerdown="{seek}" onpointermove="if(event.buttons){{{seek}}}"'


def visiting(time: float) -> str:
    """Return attributes by which a touch goes to a key frame and stops there."""
    return f'onpointerdown="event.stopPropagation();{asking("mossar/visit", f"{time!r}")}"'


def symbol(kind: str, classes: str = "final") -> str:
    """Return the symbol of a kind of key frame as a small picture."""
    return (
        f'<svg width="12" height="12" viewBox="-6 -6 12 12"><path class="mark {kind} {classes}" '
        f'd="{SYMBOLS[kind]}"/></svg>'
    )


def _legend() -> str:
    kinds = "".join(f"<span>{symbol(kind)} {kind}</span>" for kind in SYMBOLS)
    undecided = f"<span>{symbol('minimum', '')} undecided</span>"
    merged = '<span><svg width="9" height="9" viewBox="-4.5 -4.5 9 9"><path class="mark merged minimum" '
    merged += 'd="M-3-3L3 3M3-3L-3 3"/></svg> merged</span>'
    band = '<span><svg width="20" height="10"><rect class="band" width="20" height="10"/></svg> floor to ceiling</span>'
    theta = (
        '<span><svg width="20" height="10"><line class="theta" x2="20" y1="5" y2="5"/></svg> threshold</span>'
    )
    return f'<span class="m-legend">{kinds}{undecided}{merged}{band}{theta}</span>'


def _row(glimpse: Glimpse, top: float, height: float, *, named: bool, seeks: bool) -> str:
    limbs = min(_LIMB_STRIP * len(glimpse.limbs), height / 3)
    room = height - _STRIP - _GAP - 8 - limbs
    curve, place = glimpse.curve, _placer(glimpse)
    value, high = np.nan_to_num(curve.value), glimpse.top
    x = _BOX * (curve.times - glimpse.start) / (glimpse.end - glimpse.start)
    lines = (
        f'<svg class="box" x="0" y="{top + 8:.1f}" width="100%" height="{room:.1f}" '
        f'viewBox="0 0 {_BOX:.0f} 100" preserveAspectRatio="none">'
        f'<path class="band" d="{_between(x, curve.floor, curve.ceiling, high)}"/>'
        f'<path class="area" d="{_between(x, np.zeros_like(value), value, high)}"/>'
        f'<line class="theta" x1="0" x2="{_BOX:.0f}" y1="{_y(glimpse.threshold, high):.1f}" '
        f'y2="{_y(glimpse.threshold, high):.1f}"/>'
        f'<path class="curve" d="M{_points(x, value, high)}"/></svg>'
    )
    baseline = top + 8 + room
    axis = f'<line class="axis" x1="0" x2="100%" y1="{baseline:.1f}" y2="{baseline:.1f}"/>'
    marks = "".join(
        _symbol(m, place(m.time), top + 8 + room * _y(glimpse.height(m), high) / 100, baseline, seeks=seeks)
        for m in glimpse.marks
    )
    strip = _segments(glimpse, baseline + _GAP) + _limb_strips(glimpse, baseline + _GAP + _STRIP, limbs)
    strip += _moves(glimpse, top + 8)
    head = ""
    if glimpse.now < glimpse.end:
        at = place(glimpse.now)
        head = (
            f'<line class="head" x1="{at}" x2="{at}" y1="{top + 4:.1f}" y2="{baseline + _GAP + _STRIP:.1f}"/>'
        )
    name = f'<text class="name" x="4" y="{top + 20:.1f}">{escape(glimpse.performer)}</text>' if named else ""
    return axis + lines + strip + marks + head + name


def _symbol(mark: Mark, place: str, y: float, baseline: float, *, seeks: bool) -> str:
    """Return stem and symbol of a key frame, with its fields as a tooltip."""
    strength = "" if mark.strength is None else f", strength {mark.strength:.2f}"
    title = f"<title>{mark.kind} at {mark.time:.2f} s, frame {mark.frame}{strength}</title>"
    touch = visiting(mark.time) if seeks else ""
    title += '<circle class="touch" r="9"/>' * seeks
    if not mark.kept and not mark.tentative:
        cross = "M-3-3L3 3M3-3L-3 3"
        return f'<svg x="{place}" y="{y:.1f}" {touch}><path class="mark merged {mark.kind}" d="{cross}"/>{title}</svg>'
    state = "tentative" if mark.tentative else "final" if mark.decided else ""
    stem = (
        ""
        if mark.tentative
        else f'<line class="stem {mark.kind}" x1="{place}" x2="{place}" y1="{y:.1f}" y2="{baseline + _GAP + _STRIP:.1f}"/>'
    )
    return (
        f'{stem}<svg x="{place}" y="{y:.1f}" {touch}><path class="mark {state} {mark.kind}" d="{SYMBOLS[mark.kind]}"/>'
        f"{title}</svg>"
    )


def _segments(glimpse: Chart, top: float) -> str:
    """Return the segments as bars coloured by state, with a word where there is room."""
    bars = []
    for part in glimpse.stretches:
        left, width = _within(glimpse, part)
        bars.append(
            f'<rect class="{part.state}" x="{left:.2f}%" y="{top:.1f}" width="{max(width - 0.12, 0.05):.2f}%" '
            f'height="{_STRIP}" rx="3"/>'
        )
        if width > 5:
            word = (
                f'{part.state}<tspan class="more"> {part.end - part.start:.1f} s</tspan>'
                if width > 9
                else part.state
            )
            middle = f'x="{left + width / 2:.2f}%" y="{top + 14:.1f}"'
            wide = "" if width > 20 else " wide"  # on a phone there is room in the longest only
            bars.append(f'<text class="in{wide}" text-anchor="middle" {middle}>{word}</text>')
    return "".join(bars)


def _limb_strips(glimpse: Chart, top: float, room: float) -> str:
    """Return a thin strip for each limb, coloured by state."""
    parts = []
    each = room / max(1, len(glimpse.limbs))
    for place, (limb, stretches) in enumerate(glimpse.limbs.items()):
        y = top + place * each + 2
        for part in stretches:
            left, width = _within(glimpse, part)
            parts.append(
                f'<rect class="limb {part.state}" x="{left:.2f}%" y="{y:.1f}" width="{max(width - 0.12, 0.05):.2f}%" '
                f'height="{each - 2:.1f}"><title>{escape(limb)}</title></rect>'
            )
        name = escape(limb.replace("_", " "))
        parts.append(f'<text class="limb" x="4" y="{y + each - 3:.1f}">{name}</text>')
    return "".join(parts)


def _moves(glimpse: Chart, top: float) -> str:
    """Return the names of the moves that were recognised, above the curve, from where they begin to where they end."""
    parts = []
    for move in glimpse.moves:
        left, width = _within(glimpse, move)
        parts.append(
            f'<rect class="move" x="{left:.2f}%" y="{top:.1f}" width="{width:.2f}%" height="15" rx="3"/>'
            f'<text class="move" x="{left:.2f}%" dx="3" y="{top + 11:.1f}">{escape(move.name)}</text>'
        )
    return "".join(parts)


def _time_axis(glimpse: Chart, top: float) -> str:
    place = _placer(glimpse)
    step = 2.0
    first = np.ceil(glimpse.start / step) * step
    ticks = np.arange(max(first, 0.0), glimpse.end, step)
    return "".join(
        f'<text class="{"wide" if t % (2 * step) else ""}" x="{place(t)}" y="{top + 14:.1f}" '
        f'text-anchor="middle">{clock(t)}</text>'
        for t in ticks
        if glimpse.start + 0.4 < t < glimpse.end - 0.4
    )


def clock(time: float) -> str:
    """Return a time as people read it.

    Example:
        >>> clock(8), clock(98), clock(3723)
        ('8 s', '1:38', '1:02:03')
    """
    minutes, seconds = divmod(round(time), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours}:{minutes:02}:{seconds:02}"
    return f"{minutes}:{seconds:02}" if minutes else f"{seconds} s"


def _within(glimpse: Chart, part: Stretch | NamedMove) -> tuple[float, float]:
    """Return the left edge and the width of a stretch, in percent of the chart."""
    start, end = max(part.start, glimpse.start), min(part.end, glimpse.end)
    scale = 100 / (glimpse.end - glimpse.start)
    return (start - glimpse.start) * scale, (end - start) * scale


def _placer(glimpse: Chart) -> Callable[[float], str]:
    """Return a function from a time to a horizontal place."""
    scale = 100 / (glimpse.end - glimpse.start)
    return lambda time: f"{(time - glimpse.start) * scale:.2f}%"


def _y(value: float, high: float) -> float:
    """Return a velocity as a share of the height from the top, in percent."""
    return 100 * (1 - min(max(value / high, 0.0), 1.0))


def _points(x: NDArray[np.float64], values: NDArray[np.float64], high: float) -> str:
    y = 100 * (1 - np.clip(np.nan_to_num(values) / high, 0.0, 1.0))
    return "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x.tolist(), y.tolist(), strict=True))


def _between(x: NDArray[np.float64], low: NDArray[np.float64], top: NDArray[np.float64], high: float) -> str:
    if not len(x):
        return "M0 0"
    return f"M{_points(x, top, high)}L{_points(x[::-1], low[::-1], high)}Z"
