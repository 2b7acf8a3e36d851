"""Oddities: examples that are unlike the others of their name, so that a slip while showing a move is noticed.

The limits lie beyond the values of 14 moves by 11 people and 17 moves by 5 people within one name and person (1004 pairs):
the longer one took at most 1.83 times as long, the cosine of the postures was at least 0.938, and of the costs 0.4 % were
above 1.
"""

from typing import Literal

import msgspec
import numpy as np

Difference = Literal["duration", "posture", "movement"]

LONGER_THAN_OTHERS = 2.0  # times the median duration of the others, or that many times shorter
LEAST_POSTURE = 0.93  # cosine between the mean postures of an example and of the nearest other
MOST_COST = 1.0  # of taking an example for the nearest other


class Oddity(msgspec.Struct, frozen=True):
    """The differences of an example from the others of its name.

    Args:
        differences: In which respects; never empty.
        seconds: Of the example's movement.
        others: s, median of the others.
        posture: Cosine between its mean posture and that of the nearest other.
        cost: Of taking it for the nearest other; see `Moves.costs`.
        nearer: Another move that costs less than its own, if there is one; else empty.
    """

    differences: tuple[Difference, ...]
    seconds: float
    others: float
    posture: float
    cost: float
    nearer: str


def oddity_of(
    seconds: float, others: np.ndarray, postures: np.ndarray, costs: np.ndarray, nearest: tuple[str, float]
) -> Oddity | None:
    """Return the differences of an example from the others of its name; None if there are none.

    Args:
        seconds: Of the example's movement.
        others: (n,) s of the others of its name, n above 0.
        postures: (n,) cosines with their mean postures.
        costs: (n,) of taking it for each of them.
        nearest: Name and cost of the nearest example of another name; the cost is infinite if there is none.
    """
    middle = float(np.median(others))
    posture, cost = float(postures.max()), float(costs.min())
    nearer = nearest[0] if nearest[1] < cost else ""
    differences: list[Difference] = []
    if not 1.0 / LONGER_THAN_OTHERS <= seconds / middle <= LONGER_THAN_OTHERS:
        differences.append("duration")
    if posture < LEAST_POSTURE:
        differences.append("posture")
    if cost > MOST_COST or nearer:
        differences.append("movement")
    if not differences:
        return None
    return Oddity(tuple(differences), seconds, middle, posture, cost, nearer)
