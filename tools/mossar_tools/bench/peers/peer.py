"""Peer: what another library looks like to the contest."""

from collections.abc import Callable, Mapping
from typing import Any, Literal, Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream.joints import localise
from mossar_stream.settings import Settings
from mossar_tools.evaluation.takes import Take
from mossar_tools.evaluation.velocity_based import velocity

Feed = Literal["curve", "poses", "positions"]
Parameters = Mapping[str, float | str]


class Detector(Protocol):
    """Finds cuts in a stream of one take."""

    def update(self, sample: NDArray[Any], time: float) -> list[float]:
        """Take the next sample in and return the times of cuts that this decides, s.

        Args:
            sample: (D,), D = 1 for the curve.
            time: s.
        """

    def finish(self) -> list[float]:
        """Return the times of cuts that the end of the take decides."""


class Causal:
    """A detector that has nothing to say when a take ends."""

    def finish(self) -> list[float]:
        """See `Detector`."""
        return []


class Peer(msgspec.Struct, frozen=True):
    """Another library's way to find cuts.

    Args:
        name: For the table.
        library: Import name.
        distribution: What to install.
        feed: `curve`: mean joint speed, m/s; `poses`: coordinates relative to the centre, m; `positions`: as they are.
        make: Returns a detector for a rate, Hz, and parameters.
        grid: Values that were tried.
        best: The best of them, by level.
        knows: What it knows, or does, that the others do not.
    """

    name: str
    library: str
    distribution: str
    feed: Feed
    make: Callable[[float, Parameters], Detector]
    grid: Mapping[str, tuple[float | str, ...]]
    best: Mapping[str, Parameters]
    knows: str = ""


def samples(take: Take, feed: Feed) -> NDArray[Any]:
    """Return what a peer is fed: (n, D), or (n, J, 3) float32."""
    if feed == "positions":
        return take.positions
    if feed == "poses":
        local = localise(take.positions.astype(np.float64), take.skeleton.root)
        return np.nan_to_num(local.reshape(len(local), -1))
    settings = Settings(level=take.level)
    window = settings.resolved().window or 1.0
    times, curve = velocity(take, settings)
    speed = curve / (window * len(take.skeleton))
    return np.interp(take.times, times, speed)[:, None]
