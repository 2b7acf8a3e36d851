"""Peer: the interface of another library for the runner."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import msgspec
from numpy.typing import NDArray

from checks.peers.feeds import FeedName

Parameters = Mapping[str, float | str]


class Detector(Protocol):
    """Finds cuts in a stream of one take."""

    def update(self, sample: NDArray[Any], time: float) -> list[float]:
        """Process the next sample, and return the times of cuts that this decides, s.

        Args:
            sample: (D,), D = 1 for the curve.
            time: s.
        """

    def finish(self) -> list[float]:
        """Return the times of cuts that the end of the take decides."""


class Causal:
    """A detector without cuts at the end of a take."""

    def finish(self) -> list[float]:
        """See `Detector`."""
        return []


class Peer(msgspec.Struct, frozen=True):
    """Another library's way to find cuts.

    Args:
        name: For the table.
        library: Import name.
        distribution: Name of the distribution.
        feed: `curve`: mean joint speed, m/s; `poses`: coordinates relative to the centre, m.
        make: Returns a detector for a rate, Hz, and parameters.
        grid: Values that were tried.
        best: The best of them, by level.
    """

    name: str
    library: str
    distribution: str
    feed: FeedName
    make: Callable[[float, Parameters], Detector]
    grid: Mapping[str, tuple[float | str, ...]]
    best: Mapping[str, Parameters]
