"""The protocol of profiles: OSC messages in, metas, poses and leavings out."""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import msgspec

from mossar_adapters.address import Address
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.live import Counters
from mossar_adapters.receiving.pose import Pose
from mossar_adapters.receiving.senders import Senders
from mossar_adapters.source import Departure, Meta

Items = Sequence[Meta | Pose | Departure]
NOTHING: Items = ()


class Message(NamedTuple):
    """One OSC message.

    Args:
        address: With the leading slash, if the sender gives one.
        arguments: As python-osc gives them.
        sender: Distinguishes this sender's performers from others', see `Senders.suffix`.
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

    def receive(self, message: Message) -> Items:
        """Return the poses that this message completes, in order.

        Raises:
            FrameError: If it is malformed; nothing that was complete is lost by it.
        """

    def idle(self, now: float) -> Items:
        """Return the frames that nothing more has come for; called when nothing waits to be read."""

    def pending(self) -> bool:
        """Return whether a frame is open or held back, so that `idle` should be called soon."""


class Context(msgspec.Struct):
    """The source as its profiles know it.

    Args:
        address: The URL, for options.
        options: fps, unit, skeleton and so on from the URL or the command line.
        senders: Names performers.
        counters: The source's.
    """

    address: Address
    options: ReadOptions
    senders: Senders
    counters: Counters
