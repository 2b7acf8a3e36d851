"""Recent: a bounded number of senders or performers. A newcomer takes the place of the one that has been silent longest."""

from collections import OrderedDict
from collections.abc import ItemsView, ValuesView
from typing import Generic, TypeVar

from mossar_stream import FrameError

SILENT = 2.0  # s, after which one may be forgotten

Kept = TypeVar("Kept")


class Recent(Generic[Kept]):
    """A record of each sender or performer, by name, least recently heard first.

    A flood of new names never takes the place of one that still sends: it is refused instead.

    Args:
        most: Largest number of records.
        what: Plural of their subject, for messages.
    """

    def __init__(self, most: int, what: str) -> None:
        self._most, self._what = most, what
        self._kept: OrderedDict[str, Kept] = OrderedDict()
        self._heard: dict[str, float] = {}  # s, of each

    def __len__(self) -> int:
        return len(self._kept)

    def get(self, name: str) -> Kept | None:
        """Return the record of a name."""
        return self._kept.get(name)

    def hear(self, name: str, now: float) -> Kept | None:
        """Return the record of a name, which is heard now, s."""
        found = self._kept.get(name)
        if found is not None:
            self._kept.move_to_end(name)
            self._heard[name] = now
        return found

    def make_room(self, newcomer: str, now: float) -> tuple[str, Kept] | None:
        """Forget the one that has been silent longest if all places are taken, and return it with its name.

        Raises:
            FrameError: If it was heard less than 2 s ago; nothing is forgotten then.
        """
        if len(self._kept) < self._most:
            return None
        silent = next(iter(self._kept))
        if now - self._heard[silent] < SILENT:
            raise FrameError(
                f"{self._most} {self._what} are known and all of them move; {newcomer} is refused"
            )
        return silent, self.pop(silent)

    def add(self, name: str, kept: Kept, now: float) -> Kept:
        """Keep something under a new name, for which there is room."""
        self._kept[name] = kept
        self._heard[name] = now
        return kept

    def pop(self, name: str) -> Kept:
        """Forget a name, and return its record.

        Raises:
            KeyError: If it is not known.
        """
        del self._heard[name]
        return self._kept.pop(name)

    def items(self) -> ItemsView[str, Kept]:
        """Return names and records, the one that has been silent longest first."""
        return self._kept.items()

    def values(self) -> ValuesView[Kept]:
        """Return the records, that of the name that has been silent longest first."""
        return self._kept.values()
