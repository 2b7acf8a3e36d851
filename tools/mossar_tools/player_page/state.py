"""State: the page's view of one performer at one moment, as a map for its script."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from mossar_tools.dashboard.glimpse import FollowedMove, Glimpse
from mossar_tools.player_page.outline import outline_of
from mossar_tools.player_page.verdicts import Judge, Verdict, is_judged

_RESTS: Final = Verdict("resting", "wait")
_MOVES: Final = Verdict("moving", "good")
State = dict[str, Any]


def state_of(glimpse: Glimpse, judge: Judge, seconds: float) -> State:
    """Return the shown part of a performer.

    Args:
        glimpse: Of the performer.
        judge: Of the same performer.
        seconds: Since the start.
    """
    shown = _followed(glimpse, judge) if glimpse.followed_moves else _counted(glimpse)
    return {
        "name": glimpse.performer,
        "seconds": int(seconds),
        **shown,
        **_figure(glimpse),
    }


def _followed(glimpse: Glimpse, judge: Judge) -> State:
    """Return count, verdict, progress and tempo of the followed move that is shown large."""
    move, counts = glimpse.followed_moves[0], glimpse.count.followed
    verdict = judge.judge(glimpse)
    others = sorted(glimpse.followed_moves[1:], key=lambda one: one.name)
    followed = {one.name for one in glimpse.followed_moves}
    return {
        "title": move.name,
        "count": counts.get(move.name, 0),
        "progress": None if move.progress is None else round(move.progress, 3),
        "tempo": _tempo(move),
        "verdict": verdict.text,
        "kind": verdict.kind,
        "others": [
            *([one.name, counts.get(one.name, 0)] for one in others),
            *([name, n] for name, n in sorted(glimpse.count.moves.items()) if name not in followed and n),
        ],
    }


def _tempo(move: FollowedMove) -> str:
    """Return the tempo relative to the example; empty before the first performance."""
    return f"{move.tempo:.1f} ×" if move.progress is not None or move.score is not None else ""  # noqa: RUF001


def _counted(glimpse: Glimpse) -> State:
    """Return the count of recognised moves or of repetitions, where no move is followed."""
    count = glimpse.count
    verdict = _MOVES if glimpse.moving else _RESTS
    if count.held is not None:
        verdict = Verdict(f"{count.held.name} {count.held.seconds:.0f} s", "good")
    shown: State = {"title": "", "count": None, "others": [], "tempo": ""}
    if count.repetitions is not None:
        shown |= {"title": "repetitions", "count": count.repetitions}
        shown["tempo"] = "" if count.tempo is None else f"{count.tempo:.0f} a minute"
    elif count.latest:
        others = [[name, n] for name, n in sorted(count.moves.items()) if name != count.latest and n]
        shown |= {"title": count.latest, "count": count.moves[count.latest], "others": others}
    return {**shown, "progress": None, "verdict": verdict.text, "kind": verdict.kind}


def _figure(glimpse: Glimpse) -> State:
    """Return the body, and the example over it, as points in millimetres."""
    outline, body, example = outline_of(glimpse.skeleton), glimpse.body, glimpse.overlay
    found: State = {"outline": outline.drawn(), "points": None, "strays": None, "example": None}
    if body is None:
        return found
    found["points"] = whole(outline.points(body.joints) * 1000)
    if example is not None and is_judged(glimpse.followed_moves[0]):
        other = outline_of(example.skeleton)
        found["strays"] = whole(outline.strays(body.joints, example.joints, other))
        found["example"] = {**other.drawn(), "points": whole(other.points(example.joints) * 1000)}
    return found


def whole(values: NDArray[np.float32]) -> list[Any]:
    """Return numbers rounded to whole ones, None for NaN; a row of an array with a NaN is None."""
    if values.ndim == 1:
        return [round(value) if np.isfinite(value) else None for value in values.tolist()]
    return [[round(value) for value in row] if all(np.isfinite(row)) else None for row in values.tolist()]
