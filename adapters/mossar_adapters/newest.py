"""Newest: a table that holds so many entries at most; the one that was set longest ago makes room."""

from collections import OrderedDict
from typing import TypeVar

Key = TypeVar("Key")
Value = TypeVar("Value")


class Newest(OrderedDict[Key, Value]):
    """The entries that were set last, in that order.

    Args:
        most: How many are kept.

    Example:
        >>> table = Newest(2)
        >>> table.update(a=1, b=2, a_again=3)
        >>> list(table)
        ['b', 'a_again']
    """

    def __init__(self, most: int) -> None:
        super().__init__()
        self._most = most

    def __setitem__(self, key: Key, value: Value) -> None:
        """Set an entry, which becomes the newest one."""
        super().__setitem__(key, value)
        self.move_to_end(key)
        if len(self) > self._most:
            self.popitem(last=False)
