"""Station: what the loop needs to know of one performer: where the rows of body and limbs lie, and who reads the frames.

All of that is one piece of bytes with addresses, so that a compiled call takes one argument for it. The addresses hold as
long as the arrays that are kept here; `refresh` follows rows that moved.
"""

from collections.abc import Sequence
from functools import lru_cache
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import ALL_ANALYSES, CHANGES, NO_ANALYSIS, RECORDS
from mossar_stream.core.plan import Plan
from mossar_stream.core.pool import Row
from mossar_stream.core.row import new_memory
from mossar_stream.readers import Reader

STATION, CHANNEL, READER = RECORDS["Station"], RECORDS["Channel"], RECORDS["Reader"]
HEAD, SEAT = RECORDS["LoopHead"], RECORDS["Seat"]
STATION_BYTES, CHANNEL_BYTES, READER_BYTES = STATION.itemsize, CHANNEL.itemsize, READER.itemsize
HEAD_BYTES = HEAD.itemsize
KNOWN = 64  # sets of plans whose parameters are remembered


class Station:
    """One performer as the loop knows it.

    Args:
        rows: Of the body, then of the limbs.
        joints: Of each limb: which joints of the performer they are; a negative one is the middle of the body.
        readers: Of its frames, in the order in which they report.
        phase: Whether the phase of each frame is reported.

    Attributes:
        rows: The same.
        readers: The same.
        address: Where its bytes lie.
        params: (1 + L,) records of the similarity measure, for body and limbs.
    """

    def __init__(
        self, rows: Sequence[Row], joints: Sequence[Sequence[int]], readers: Sequence[Reader], *, phase: bool
    ) -> None:
        self.rows, self.readers = tuple(rows), tuple(readers)
        order = [joint for own in joints for joint in own]
        parts = (
            STATION_BYTES,
            CHANNEL_BYTES * len(rows),
            READER_BYTES * len(readers),
            8 * len(order),
            12 * len(order),
        )
        _, channels, self._readers_at, order_at, frame_at = np.cumsum([0, *parts[:-1]]).tolist()
        self._bytes = new_memory(1, sum(parts))[0]
        self.address = int(self._bytes.ctypes.data)
        self._channels = self._bytes[channels : self._readers_at].view(CHANNEL)
        self._bytes[order_at:frame_at].view(np.int64)[:] = order
        ends = np.cumsum([0, *map(len, joints)]).tolist()
        self._channels["first"] = [-1, *ends[:-1]]
        self._channels["joints"][1:] = np.diff(ends)
        self._head = self._bytes[:STATION_BYTES].view(STATION)
        self._head[0] = len(rows) - 1, len(readers), phase, len(order), order_at, frame_at
        self.params = _params_of(tuple(row.plan for row in rows))
        self.refresh()

    def refresh(self) -> None:
        """Follow rows that moved, and readers whose stores are others."""
        for channel, row in zip(self._channels, self.rows, strict=True):
            channel["row"], channel["row_bytes"] = row.memory.ctypes.data, len(row.memory)
            channel["heed"] = (
                ALL_ANALYSES
                if row.analyses is not None
                else CHANGES
                if row.reporter is not None
                else NO_ANALYSIS
            )
        table = self._bytes[self._readers_at :][: READER_BYTES * len(self.readers)].view(READER)
        for place, reader in zip(table, self.readers, strict=True):
            state, store = reader.state, reader.store
            place["call"] = reader.address
            place["state"], place["state_bytes"] = state.ctypes.data, len(state)
            place["store"], place["store_bytes"] = store.ctypes.data, len(store)
        # Addresses keep nothing alive.
        self._kept = [*(row.memory for row in self.rows), *((one.state, one.store) for one in self.readers)]

    @property
    def body(self) -> Row:
        """The row of the body."""
        return self.rows[0]


class Desk:
    """Performers whose frames are processed in one call.

    Args:
        stations: Of the performers; all with the same parameters.
        begins: Which of the frames are the first of each.
        count: How many each has; 0 for all there are.

    Attributes:
        stations: The same.
        begins: The same.
        memory: Bytes, for the compiled call.
        params: Of all of them.
        buffers: The same.
        head: (1,) HEAD.
        stopped: (1,) why the loop stopped, until that is done.
    """

    def __init__(self, stations: Sequence[Station], begins: Sequence[int] = (0,), count: int = 0) -> None:
        self.stations, self.begins = stations, begins
        self.memory = new_memory(1, HEAD_BYTES + SEAT.itemsize * len(stations))[0]
        seats = self.memory[HEAD_BYTES:].view(np.int64).reshape(-1, 2)
        seats[:, 0] = [station.address for station in stations]
        seats[:, 1] = begins
        self.head = self.memory[:HEAD_BYTES].view(HEAD)
        self.head["performers"], self.head["count"] = len(stations), count
        self.stopped = self.head["stopped"]
        self.params, self.buffers = stations[0].params, stations[0].body.buffers

    def begin_anew(self) -> None:
        """Leave the frames out that are not processed."""
        self.head[["performer", "frame", "stage", "stopped"]] = 0


def desk_of(row: Row, readers: Sequence[Reader] = ()) -> Desk:
    """Return a desk of one performer without limbs."""
    return Desk([Station([row], [], readers, phase=False)])


_same: WeakValueDictionary[tuple[object, bytes], NDArray[np.void]] = WeakValueDictionary()


@lru_cache(KNOWN)
def _params_of(plans: tuple[Plan, ...]) -> NDArray[np.void]:
    """Return the parameters of body and limbs: the same array for the same numbers, as stations of one desk have it."""
    params = np.empty(len(plans), plans[0].params.dtype)
    for place, plan in enumerate(plans):
        params[place] = plan.params[0]
    return _same.setdefault((params.dtype, params.tobytes()), params)
