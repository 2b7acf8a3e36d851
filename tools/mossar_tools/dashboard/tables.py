"""Tables: state, statistics and the last key frames, as HTML beside the controls."""

from html import escape

from mossar_tools.dashboard.chart import symbol, visiting
from mossar_tools.dashboard.glimpse import Glimpse, Repeated
from mossar_tools.dashboard.rings import followed_rows
from mossar_tools.marks import Mark

ROWS = 8  # key frames listed
WAITING = "waiting for frames …"


def state_card(
    glimpses: list[Glimpse], *, frozen: bool, recording: str, frames: int, waits_for: str = WAITING
) -> str:
    """Return the present state of each performer.

    Args:
        glimpses: One performer each.
        frozen: Whether the picture stands still.
        recording: Name of the file being recorded; empty if none is.
        frames: Recorded so far.
        waits_for: Why there is no performer yet.
    """
    if not glimpses:
        return f'<div class="mossar m-card state"><span class="dim" id="mossar-waiting">{escape(waits_for)}</span></div>'
    rows = []
    for glimpse in glimpses:
        word = "moving" if glimpse.moving else "resting"
        rows.append(
            '<div class="mossar m-card state">'
            f'<span><span class="m-pill {word}">{word}</span> &nbsp;<b>{escape(glimpse.performer)}</b></span>'
            f'<span class="big">{glimpse.now:.1f}<span class="dim" style="font-size:13px"> s</span></span></div>'
        )
        if glimpse.followed_moves:  # one count: a followed move is counted from the first performance on
            rows.append(followed_rows(glimpse.followed_moves))
        elif glimpse.repeated is not None:
            rows.append(_repeated(glimpse.repeated))
    notes = []
    if frozen:
        notes.append("the picture is paused; the stream continues")
    if recording:
        notes.append(
            f'<span class="m-red"></span> {escape(recording)}: <b id="mossar-frames">{frames}</b> frames'
        )
    if notes:
        rows.append(f'<div class="mossar m-card">{"<br>".join(notes)}</div>')
    return "".join(rows)


def _repeated(repeated: Repeated) -> str:
    tempo = "" if repeated.tempo is None else f"{repeated.tempo:.0f}"
    minute = '<span class="dim" style="font-size:13px"> / min</span>' if tempo else ""
    return (
        '<div class="mossar m-card state" id="mossar-repetitions">'
        f'<span class="count">{repeated.total}<span class="dim" style="font-size:13px"> times</span></span>'
        f'<span class="count">{tempo}{minute}</span></div>'
    )


def facts_card(glimpses: list[Glimpse]) -> str:
    """Return statistics, a column for each performer."""
    names = list(dict.fromkeys(name for glimpse in glimpses for name, _ in glimpse.statistics))
    columns = [dict(glimpse.statistics) for glimpse in glimpses]
    head = ""
    if len(glimpses) > 1:
        head = "<tr><th></th>" + "".join(f"<th>{escape(g.performer)}</th>" for g in glimpses) + "</tr>"
    rows = "".join(
        f'<tr><td class="dim">{escape(name)}</td>'
        + "".join(f"<td>{escape(column.get(name, ''))}</td>" for column in columns)
        + "</tr>"
        for name in names
    )
    return f'<div class="mossar m-card" id="mossar-facts"><table>{head}{rows}</table></div>'


def marks_card(glimpses: list[Glimpse], *, seeks: bool = False) -> str:
    """Return the last key frames up to now, newest first, with time and delay.

    Args:
        glimpses: One performer each.
        seeks: Whether a touch goes to a key frame.
    """
    found = [(g, mark) for g in glimpses for mark in g.marks if not mark.tentative and mark.time <= g.now]
    found.sort(key=lambda pair: -pair[1].time)
    several = len(glimpses) > 1
    rows = "".join(_mark_row(g, mark, several=several, seeks=seeks) for g, mark in found[:ROWS])
    delayed = any(mark.delay is not None for _, mark in found)
    head = (
        f"<tr><th>key frame</th><th>time</th><th>{'delay' if delayed else 'frame'}</th><th>strength</th></tr>"
    )
    return f'<div class="mossar m-card" id="mossar-marks"><table>{head}{rows}</table></div>'


def _mark_row(glimpse: Glimpse, mark: Mark, *, several: bool, seeks: bool) -> str:
    who = f'<span class="dim">{escape(glimpse.performer)}</span> ' if several else ""
    state = "final" if mark.decided else ""
    delay = str(mark.frame) if mark.delay is None else f"{mark.delay * 1000:.0f} ms"
    strength = "–" if mark.strength is None else f"{mark.strength:.2f}"  # noqa: RUF001
    return (
        f'<tr class="{"" if mark.kept else "merged"}"{f" {visiting(mark.time)}" * seeks}><td><i class="{mark.kind}">{symbol(mark.kind, state)}'
        f" {mark.kind}</i> {who}</td><td>{mark.time:.2f} s</td><td>{delay}</td><td>{strength}</td></tr>"
    )
