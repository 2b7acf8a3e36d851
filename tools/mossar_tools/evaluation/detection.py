"""Detection: the key frames that a method found in a take, and what a method is."""

import math
from collections.abc import Callable, Mapping
from typing import Literal

import msgspec

from mossar_tools.evaluation.metrics import Scores, score
from mossar_tools.evaluation.takes import Take


class Detection(msgspec.Struct, frozen=True):
    """Key frames that a method found in a take.

    Args:
        times: s, increasing.
        decided: When each was decided, s; empty where not streaming.
        seconds: What finding them took, s; NaN where it says nothing.
    """

    times: list[float]
    decided: list[float] = []
    seconds: float = math.nan

    def scores(self, take: Take) -> Scores:
        """Return how well they meet the take's true cuts."""
        return score(
            self.times,
            take.cuts,
            tolerance=take.tolerance,
            duration=take.duration,
            start=float(take.times[0]),
            decided=self.decided,
        )


Variants = Mapping[str, Detection]  # what there is to choose from, by what sets the variants apart
Choice = Literal["fixed", "best for all", "best each"]
FIXED: tuple[Choice, ...] = ("fixed",)


class Method(msgspec.Struct, frozen=True):
    """A way to find key frames.

    Args:
        name: For the tables.
        choices: How one of the variants is chosen: there is one only; the one best for all takes of a group; the
            best for each take. The latter two look at the truth.
        run: Finds key frames in a take.
        online: Whether it could run on a live stream.
    """

    name: str
    choices: tuple[Choice, ...]
    run: Callable[[Take], Variants]
    online: bool = False
