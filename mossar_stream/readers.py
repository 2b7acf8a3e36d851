"""Readers: what follows the frames of a performer besides the segmentation of body and limbs.

A reader is a compiled function with two arrays of bytes: its state of one performer, and a store that performers may share.
The loop (core/run.pxi) calls it with each frame of the body, after body and limbs, once the frame is due. If the frame causes
events, the loop stops, and the engine asks the reader in Python for its events.

A further reader is one module like `moves/recognition.py` or `steps/stepping.py`, and one row of the table in
`segmenter/followers.py`.
"""

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mossar_stream.events import Event


class Reader(Protocol):
    """What the engine needs of a reader.

    Attributes:
        address: Of the compiled function, a `See` of core/station.pxi.
        state: Bytes, never moved. The first eight are a float64, `due`: a frame from `due - BACK` until before `due`, s, brings
            nothing; -inf to see every frame.
        store: Bytes that the function needs besides; never moved, empty if there is nothing.
        reported: What was reported so far, as far as the state does not say so.
    """

    @property
    def address(self) -> int: ...  # noqa: D102
    @property
    def state(self) -> NDArray[np.uint8]: ...  # noqa: D102
    @property
    def store(self) -> NDArray[np.uint8]: ...  # noqa: D102

    reported: Any

    def report(self, take: int, origin: NDArray[np.float64] | None) -> tuple[list[Event], Any]:
        """Return the events of the last frame, and what `reported` is once they are pending; nothing is changed.

        Args:
            take: Number of the take that is open.
            origin: Where the positions are counted from, m; None for 0.
        """

    def end(self, take: int, pending: list[Event]) -> None:
        """Forget what is going on, as a take ends; add the events that this brings to `pending`."""

    def to_bytes(self) -> bytes:
        """Return the state and what was reported, for a snapshot."""
