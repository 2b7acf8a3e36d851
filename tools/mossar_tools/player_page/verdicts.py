"""Verdicts: how a performance goes, in words that are read from afar."""

from typing import Final

import msgspec
import numpy as np

from mossar_tools.dashboard.glimpse import FollowedMove, Glimpse
from mossar_tools.player_page.outline import Outline, outline_of

OFF: Final = 15.0  # degrees of the part that strays most, from which the verdict names it
_ENOUGH: Final = 5  # poses that were compared, before a part is named
# Progress from which a performance is judged while it is made; many that begin at rest end before.
_JUDGED: Final = 0.3


class Verdict(msgspec.Struct, frozen=True):
    """A verdict.

    Args:
        text: In words.
        kind: `good`, `off`, or `wait` before there is something to judge.
    """

    text: str
    kind: str


READY: Final = Verdict("ready", "wait")
_GOOD: Final = Verdict("good", "good")


class Judge:
    """Judges the followed moves of one performer by the angles between bones and the example's.

    The angles are root mean squares over a performance, as `FollowEvent.deviation` is. A performance that was given up
    leaves the verdict on the one before.
    """

    def __init__(self) -> None:
        self._performance: tuple[str, int] | None = None  # name, and count before the one that is being made
        self._squares = np.zeros(0)  # (bones,) degrees², summed
        self._poses = np.zeros(0)  # (bones,) that were compared
        self._done: dict[str, Verdict] = {}  # on the performance of each move that was done last

    def judge(self, glimpse: Glimpse) -> Verdict:
        """Return the verdict on the move that is shown large, while it is made and until the next one begins."""
        move = glimpse.followed_moves[0]
        outline = outline_of(glimpse.skeleton)
        performance = None if move.progress is None else (move.name, move.count)
        if performance != self._performance:
            self._conclude(glimpse, outline)
            self._performance = performance
            self._squares, self._poses = np.zeros((2, len(outline.bones)))
        self._compare(glimpse, outline)
        if is_judged(move):
            return self._verdict(move, outline)
        return self._done.get(move.name, READY)

    def _conclude(self, glimpse: Glimpse, outline: Outline) -> None:
        """Keep the verdict on the performance that has ended, if it was done."""
        counts = {move.name: move for move in glimpse.followed_moves}
        name, before = self._performance or ("", 0)
        if name in counts and counts[name].count > before:
            self._done[name] = self._verdict(counts[name], outline)

    def _compare(self, glimpse: Glimpse, outline: Outline) -> None:
        """Add the angles of one pose."""
        example, body = glimpse.overlay, glimpse.body
        if self._performance is None or example is None or body is None:
            return
        angles = outline.strays(body.joints, example.joints, outline_of(example.skeleton))
        known = np.isfinite(angles)
        self._squares += np.where(known, angles, 0.0) ** 2
        self._poses += known

    def _verdict(self, move: FollowedMove, outline: Outline) -> Verdict:
        """Return the verdict on the part that strayed most, or on the limb where too few poses were compared."""
        part, angle = self._worst(outline) or (move.limb.replace("_", " "), move.angle)
        return Verdict(f"{part} {angle:.0f}° off", "off") if part and angle >= OFF else _GOOD

    def _worst(self, outline: Outline) -> tuple[str, float] | None:
        """Return the part that strayed most, and its angle, degrees; None if too little was compared."""
        if len(self._poses) != len(outline.bones):
            return None
        named = np.array([bool(part) for part in outline.parts], np.bool_) & (self._poses >= _ENOUGH)
        if not named.any():
            return None
        angles = np.sqrt(np.where(named, self._squares / np.maximum(self._poses, 1), 0.0))
        worst = int(np.argmax(np.where(named, angles, -1.0)))
        return outline.parts[worst], float(angles[worst])


def is_judged(move: FollowedMove) -> bool:
    """Return whether a move is being made, and has come so far that it will hardly be given up."""
    return move.progress is not None and move.progress >= _JUDGED
