"""Pages: rows of memory for performers who share skeleton, settings and rate, so that one call serves many."""

from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.frame_step import DONE, RING_FULL, TAKE_ENDS
from mossar_stream.algorithm.row import ROW, ROW_BYTES, new_memory
from mossar_stream.engine.buffers import Desk
from mossar_stream.engine.engine import OUTBOX_FULL
from mossar_stream.engine.plan import Plan
from mossar_stream.events import Event
from mossar_stream.segmenter import Segmenter

ROWS = 64  # of a page; memory is taken when a row is used first


class Seat(NamedTuple):
    """A row of a page."""

    page: "Page"
    row: int

    def vacate(self) -> None:
        """Give the row back."""
        self.page.leave(self.row)


class Page:
    """Rows of one plan.

    Args:
        plan: How the rows are laid out.
        desk: Shared by all of them.
    """

    def __init__(self, plan: Plan, desk: Desk) -> None:
        self._plan = plan
        self._desk = desk
        self._memory = new_memory(ROWS, plan.row_bytes)
        self._headers = self._memory[:, :ROW_BYTES].view(ROW)[:, 0]["clock"]
        self._free = list(range(ROWS))[::-1]
        self._used: set[int] = set()
        self._names: dict[int, str] = {}

    @property
    def is_full(self) -> bool:
        """Whether there is no row left."""
        return not self._free

    def seat(self, performer: str) -> Segmenter:
        """Return a segmenter that begins in a free row."""
        row = self._free.pop()
        memory = self._memory[row : row + 1]
        if row in self._used:
            memory[:] = 0
        self._used.add(row)
        self._plan.prepare(memory[0], row)
        self._names[row] = performer
        return Segmenter.at_row(self._plan, memory, self._desk, performer, Seat(self, row))

    def leave(self, row: int) -> None:
        """Take back a row."""
        del self._names[row]
        self._free.append(row)

    def push(
        self,
        rows: NDArray[np.int64],
        segmenters: Sequence[Segmenter],
        begins: NDArray[np.int64],
        ends: NDArray[np.int64],
        positions: NDArray[np.float32],
        times: NDArray[np.float64],
    ) -> list[Event]:
        """Take frames of performers of this page in and return the events they cause.

        Args:
            rows: (m,) their rows.
            segmenters: The same performers' segmenters.
            begins: (m,) where each one's frames begin.
            ends: (m,) where they end.
            positions: (n, J, 3) m.
            times: (n,) s.
        """
        events: list[Event] = []
        cursor, stop = np.zeros(2, np.int64), OUTBOX_FULL
        while stop != DONE:
            closed = np.flatnonzero(self._headers["open"][rows] == 0)
            stop = self._desk.run(self._memory, rows, begins, ends, cursor, positions, times)
            opened = closed[self._headers["open"][rows[closed]] == 1]
            events += [segmenters[k].opened() for k in opened.tolist()]
            events += self._desk.empty(self._names)
            if stop in (TAKE_ENDS, RING_FULL):
                # The performer's own segmenter knows what to do; the others go on after it.
                k, used = cursor.tolist()
                rest = slice(int(begins[k]) + used, int(ends[k]))
                events += segmenters[k].push(positions[rest], times[rest])
                cursor[:] = k + 1, 0
        return events


class Pages:
    """Pages of one plan, as many as are needed.

    Args:
        plan: How the rows are laid out.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._desk = Desk(plan)
        self._pages: list[Page] = []

    def seat(self, performer: str) -> Segmenter:
        """Return a segmenter that begins in a free row."""
        if not self._pages or self._pages[-1].is_full:
            self._pages = [page for page in self._pages if not page.is_full]
            if not self._pages:
                self._pages.append(Page(self._plan, self._desk))
        return self._pages[-1].seat(performer)


def push_block(
    segmenters: Sequence[Segmenter],
    positions: NDArray[np.float32],
    times: NDArray[np.float64],
) -> list[Event]:
    """Take as many frames of each of many performers in, page by page, and return the events they cause.

    Args:
        segmenters: P segmenters.
        positions: (P, n, J, 3) m.
        times: (P, n) s.
    """
    count = positions.shape[1]
    flat, moments = positions.reshape(-1, *positions.shape[2:]), times.reshape(-1)
    events: list[Event] = []
    seated: dict[Page, tuple[list[int], list[int]]] = defaultdict(lambda: ([], []))
    for k, segmenter in enumerate(segmenters):
        seat = segmenter.seat
        if isinstance(seat, Seat):
            members, places = seated[seat.page]
            members.append(k)
            places.append(seat.row)
        else:
            events += segmenter.push(positions[k], times[k])
    for page, (members, places) in seated.items():
        own = [segmenters[k] for k in members]
        rows, begins = np.array(places), np.array(members) * count
        for segmenter in own:
            if segmenter.pending:
                events += segmenter.take_pending()
        events += page.push(rows, own, begins, begins + count, flat, moments)
    return events
