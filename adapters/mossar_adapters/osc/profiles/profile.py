"""What every profile is given: one message at a time in, whole frames out."""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol, cast

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.address import Address
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.live import Counters
from mossar_adapters.receiving.batch import Batch
from mossar_adapters.receiving.senders import Senders
from mossar_adapters.source import Meta
from mossar_stream.skeleton import Skeleton


class Message(NamedTuple):
    """One OSC message.

    Args:
        address: With the leading slash.
        arguments: As python-osc gives them.
        sender: What tells this sender's performers from others', see `Senders.suffix`.
        arrival: Seconds since the socket opened.
    """

    address: str
    arguments: Sequence[Any]
    sender: str
    arrival: float


class Profile(Protocol):
    """A way of sending skeletons over OSC."""

    name: str

    def claims(self, message: Message) -> bool:
        """Return whether `auto` should hand this message over."""

    def take(self, message: Message) -> None:
        """Use a message.

        Raises:
            FrameError: If it is malformed.
        """

    def idle(self, now: float) -> None:
        """Close frames that nothing more has come for; called when nothing waits to be read."""

    def pending(self) -> bool:
        """Return whether a frame is open or held back, so that `idle` should be called soon."""


class Intake(msgspec.Struct):
    """Where profiles put what they find, and what the user said about the source.

    Args:
        address: The URL, for options.
        options: fps, unit, skeleton and so on from the URL or the command line.
        batch: Collects the frames.
        senders: Names performers.
        counters: The source's.
    """

    address: Address
    options: ReadOptions
    batch: Batch
    senders: Senders
    counters: Counters

    def frame(
        self,
        performer: str,
        skeleton: Skeleton,
        positions: NDArray[np.float64] | NDArray[np.float32],
        arrival: float,
        *,
        time: float | None = None,
        confidence: NDArray[np.float64] | None = None,
        unit: str = "m",
    ) -> None:
        """Add one frame, announcing the performer if its skeleton is new.

        Args:
            performer: Name.
            skeleton: Of these positions.
            positions: (J, 3) metres.
            arrival: s.
            time: The sender's time, s, or None.
            confidence: (J,) or None.
            unit: What one unit was taken for.
        """
        if self.batch.skeleton(performer) is not skeleton:
            self.batch.announce(Meta(performer, skeleton, self.options.fps, unit))
        exact = _narrowed(positions)
        shares = None
        if confidence is not None:
            shares = np.clip(np.nan_to_num(confidence), 0.0, 1.0).astype(np.float32)
        self.batch.add(performer, exact, arrival=arrival, time=time, confidence=shares)


def _narrowed(positions: NDArray[np.float64] | NDArray[np.float32]) -> NDArray[np.float32]:
    """Return positions as float32; what is too large becomes infinite."""
    if positions.dtype == np.float32:
        return cast("NDArray[np.float32]", positions)
    with np.errstate(over="ignore"):
        return positions.astype(np.float32)
