"""Detection: the key frames that a method found in a take, and the definition of a method."""

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
        decided: Time of each decision, s; empty if not streaming.
        seconds: Time that the method took, s; NaN if it is not meaningful.
    """

    times: list[float]
    decided: list[float] = []
    seconds: float = math.nan

    def scores(self, take: Take) -> Scores:
        """Return the scores against the take's true cuts."""
        return score(
            self.times,
            take.cuts,
            tolerance=take.tolerance,
            duration=take.duration,
            start=float(take.times[0]),
            decided=self.decided,
        )


Variants = Mapping[str, Detection]  # detections to choose from, by the name of the variant
Choice = Literal["fixed", "best for all", "best each"]
FIXED: tuple[Choice, ...] = ("fixed",)


class Method(msgspec.Struct, frozen=True):
    """A way to find key frames.

    Args:
        name: For the tables.
        choices: Rules for choosing a variant: the only one; the best for all takes of a group; the best for each take.
            The latter two look at the truth.
        run: Finds key frames in a take.
        online: Whether the method can run on a live stream.
    """

    name: str
    choices: tuple[Choice, ...]
    run: Callable[[Take], Variants]
    online: bool = False
