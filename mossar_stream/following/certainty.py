"""Certainty: how likely a performance that has begun will be done, calibrated on people whose examples were not used."""

import math
from collections.abc import Sequence

# Logistic regression on 18,794 messages about right and wrong repetitions, other people's examples and other exercises; each
# of five people left out in turn gives the same table of reliability within 0.09. `python -m checks.following` prints it.
CONSTANT, PROGRESS, COST, RESIDUAL, AGAIN = 0.84, 4.0, -0.36, -4.4, 1.4


def certainty(report: Sequence[float]) -> float:
    """Return how likely a performance will be done, 0..1.

    Args:
        report: Numbers of `layout.REPORT`.
    """
    _, _, count, _, _, progress, *_, cost, _, _, residual = report[:14]
    logit = CONSTANT + PROGRESS * progress + COST * min(cost, 4.0) + RESIDUAL * min(residual, 3.0)
    return round(1.0 / (1.0 + math.exp(-logit - (AGAIN if count else 0.0))), 3)
