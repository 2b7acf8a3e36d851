"""Verdicts: how a performance goes, in words that are read from afar."""

from typing import Final

import msgspec
import numpy as np

from mossar_tools.dashboard.glimpse import FollowedMove, Glimpse
from mossar_tools.player_page.outline import Outline, outline_of

OFF: Final = 15.0  # degrees of the part that strays most, from which the verdict names it
_ENOUGH: Final = 5  # poses that were compared, before a part is named
_JUDGED: Final = 0.2  # progress from which a performance is judged while it is made


class Verdict(msgspec.Struct, frozen=True):
    """A verdict.

    Args:
        text: In words.
        kind: `good`, `off`, or `wait` before there is something to judge.
    """

    text: str
    kind: str


_READY: Final = Verdict("ready", "wait")


class Judge:
    """Judges the followed moves of one performer by the angles between bones and the example's.

    The angles are root mean squares over a performance, as `FollowEvent.deviation` is.
    """

    def __init__(self) -> None:
        self._performance: tuple[str, int] | None = None  # name and count of the one that is being made
        self._squares = np.zeros(0)  # (bones,) degrees², summed
        self._poses = np.zeros(0)  # (bones,) that were compared

    def judge(self, glimpse: Glimpse) -> Verdict:
        """Return the verdict on the move that is shown large, while it is made and until the next one begins."""
        move = glimpse.followed_moves[0]
        outline = outline_of(glimpse.skeleton)
        if move.progress is not None:
            self._compare(glimpse, move, outline)
        elif move.score is None:
            return _READY
        if move.progress is not None and move.progress < _JUDGED and move.score is None:
            return _READY
        part, angle = self._worst(outline) or (move.limb.replace("_", " "), move.angle)
        return (
            Verdict(f"{part} {angle:.0f}° off", "off") if part and angle >= OFF else Verdict("good", "good")
        )

    def _compare(self, glimpse: Glimpse, move: FollowedMove, outline: Outline) -> None:
        """Add the angles of one pose."""
        if glimpse.overlay is None or glimpse.body is None:
            return
        if (performance := (move.name, move.count)) != self._performance:
            self._performance = performance
            self._squares, self._poses = np.zeros((2, len(outline.bones)))
        example = glimpse.overlay
        angles = outline.strays(glimpse.body.joints, example.joints, outline_of(example.skeleton))
        known = np.isfinite(angles)
        self._squares += np.where(known, angles, 0.0) ** 2
        self._poses += known

    def _worst(self, outline: Outline) -> tuple[str, float] | None:
        """Return the part that strayed most, and by how much, degrees; None if too little was compared."""
        if len(self._poses) != len(outline.bones):
            return None
        named = np.array([bool(part) for part in outline.parts]) & (self._poses >= _ENOUGH)
        if not named.any():
            return None
        angles = np.sqrt(np.where(named, self._squares / np.maximum(self._poses, 1), -1.0).clip(min=0.0))
        worst = int(np.argmax(np.where(named, angles, -1.0)))
        return outline.parts[worst], float(angles[worst])
