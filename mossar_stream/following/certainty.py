"""Certainty: how likely a performance that has begun will be done, calibrated on people whose examples were not used."""

import math
from collections.abc import Mapping

# Logistic regression on 18,794 messages about right and wrong repetitions, other people's examples and other exercises; each
# of five people left out in turn gives the same table of reliability within 0.09. `python -m checks.following` prints it.
CONSTANT, PROGRESS, COST, RESIDUAL, AGAIN = 0.84, 4.0, -0.36, -4.4, 1.4


def certainty(report: Mapping[str, float]) -> float:
    """Return how likely a performance will be done, 0..1.

    Args:
        report: Numbers of a `FollowReport` by name.
    """
    cost, residual = min(report["cost"], 4.0), min(report["residual"], 3.0)
    logit = CONSTANT + PROGRESS * report["progress"] + COST * cost + RESIDUAL * residual
    return round(1.0 / (1.0 + math.exp(-logit - (AGAIN if report["count"] else 0.0))), 3)
