"""A queue of many clients that take turns, so that one that floods delays only itself."""

import threading
from collections import OrderedDict, deque
from typing import Generic, TypeVar

Kept = TypeVar("Kept")


class FairQueue(Generic[Kept]):
    """Messages of clients, from threads that put them to one that gets them.

    Args:
        most: Messages that wait at a time; beyond them the oldest of the client with most go.

    Example:
        >>> queue = FairQueue(4)
        >>> for text in ("a1", "a2", "a3", "a4"):
        ...     _ = queue.put("a", text)
        >>> queue.put("b", "b1")  # one of a had to go
        1
        >>> [queue.get(0) for _ in range(5)]
        ['a2', 'b1', 'a3', 'a4', None]
    """

    def __init__(self, most: int) -> None:
        self._most = most
        # The client whose turn it is comes first.
        self._waiting: OrderedDict[object, deque[Kept]] = OrderedDict()
        self._count = 0
        self._changed = threading.Condition()

    def put(self, client: object, message: Kept) -> int:
        """Add a message of a client, and return the number of dropped ones."""
        with self._changed:
            dropped = self._make_room()
            self._waiting.setdefault(client, deque()).append(message)
            self._count += 1
            self._changed.notify()
            return dropped

    def get(self, timeout: float) -> Kept | None:
        """Return the next message, None after `timeout` seconds without one."""
        with self._changed:
            if not self._count and not self._changed.wait_for(lambda: self._count > 0, timeout):
                return None
            client, own = next(iter(self._waiting.items()))
            message = own.popleft()
            self._count -= 1
            if own:
                self._waiting.move_to_end(client)
            else:
                del self._waiting[client]
            return message

    def _make_room(self) -> int:
        """Drop the oldest message of the client with most, but never the only one: it may report that the client left."""
        if self._count < self._most:
            return 0
        longest = max(self._waiting.values(), key=len)
        if len(longest) < 2:
            return 0
        longest.popleft()
        self._count -= 1
        return 1
