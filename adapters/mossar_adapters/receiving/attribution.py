"""Attribution: which sender a datagram comes from, known with the datagram or a moment later.

Datagrams of a new port wait where it takes the next ones of the host to see whether two programs send; see
`Senders.suffix`. They go on in the order of their arrival.
"""

import math
from typing import Final, Generic, Protocol, TypeVar

from mossar_adapters.receiving.senders import Senders

MOST_WAITING: Final = 512  # datagrams


class Sent(Protocol):
    """A datagram from a port."""

    @property
    def host(self) -> str:
        """Of the sender."""

    @property
    def port(self) -> int:
        """Of the sender."""

    @property
    def arrival(self) -> float:
        """Time of arrival, s."""


Piece = TypeVar("Piece", bound=Sent)


class Attribution(Generic[Piece]):
    """Attributes datagrams to senders.

    Args:
        senders: Distinguishes them.
    """

    def __init__(self, senders: Senders) -> None:
        self._senders = senders
        self._waiting: list[Piece] = []

    @property
    def pending(self) -> bool:
        """Whether datagrams wait."""
        return bool(self._waiting)

    def put(self, piece: Piece) -> list[tuple[Piece, str]]:
        """Return the datagrams whose senders are known with this one, and the key of each sender."""
        suffix = self._senders.suffix(piece.host, piece.port, piece.arrival)
        if suffix is None:
            self._waiting.append(piece)
            return self.settle(math.inf) if len(self._waiting) > MOST_WAITING else []
        return [*self._again(), (piece, suffix)]

    def settle(self, now: float) -> list[tuple[Piece, str]]:
        """Return those that waited long enough, as nothing else came until `now`, s."""
        found: list[tuple[Piece, str]] = []
        for _ in range(len(self._waiting)):
            if not self._waiting:
                break
            first = self._waiting[0]
            suffix = self._senders.suffix(first.host, first.port, first.arrival, now)
            if suffix is None:
                break
            del self._waiting[0]
            found += [(first, suffix), *self._again()]
        return found

    def _again(self) -> list[tuple[Piece, str]]:
        """Return those that waited and whose senders are known now."""
        waiting, self._waiting = self._waiting, []
        return [found for piece in waiting for found in self.put(piece)]
