"""Explaining: the nearest move in a movement, and the reason why it was not recognised."""

from typing import Literal

import msgspec

Reason = Literal["", "cost", "lead", "posture", "agreement", "pause"]
# In the order of `BY_NOTHING`, ... in recogniser.pxi.
REASONS: tuple[Reason, ...] = ("", "cost", "lead", "posture", "agreement", "pause")


class Explanation(msgspec.Struct, frozen=True):
    """The nearest move in one movement.

    A movement ends when the body has rested for 0.67 s, when a move is recognised, or after 3 s. A move is recognised when
    its cost is below the most in two comparisons in a row.

    Args:
        performer: Name.
        start: s; begin of the compared stretch.
        end: s; end of it.
        nearest: Name of the move that came nearest.
        reason: Reason why it was not recognised: its `cost`; a `lead` that is too small, while a clear one would have
            been enough; another `posture`, without which the cost would have been low enough; `agreement`, if the cost was low in
            one comparison only; the move's own `pause`. Empty if it was recognised.
        cost: Of taking the movement for an example of the move: about 0.1 for the same, above 1 for others.
        most: The highest permitted cost with this lead, by the move's strictness.
        lead: Ratio of the second move's cost to this one's; infinite if there is none.
        second: Name of the second move; empty if there is none.
        posture: Factor of the cost that is due to another posture; 1 if the posture was as shown.
    """

    performer: str
    start: float
    end: float
    nearest: str
    reason: Reason
    cost: float
    most: float
    lead: float
    second: str
    posture: float
