"""Symbols: a kernel's name in machine code means the same in every process.

The name holds the types of the arguments. numba writes a record type there as a number, which it gives to types in the
order in which a process meets them. So two processes may give one number to two record types. Kernels that they leave in
the cache then have one name, and a third process, which loads both, runs one in place of the other. Here the name holds
what the record consists of instead.
"""

import functools
import hashlib
from typing import Any

from numba.core.types import Record


def name_records_by_contents() -> None:
    """Let numba name record types by their fields, in all kernels that are compiled from now on."""
    Record.mangling_args = property(_name_and_contents)  # type: ignore[assignment, method-assign]


def _name_and_contents(record: Any) -> tuple[str, tuple[str, ...]]:
    """Return what numba makes the name of a type of: its kind, and what tells it from others of that kind."""
    return type(record).__name__, (_digest(record.name),)


@functools.lru_cache(maxsize=256)
def _digest(contents: str) -> str:
    return hashlib.sha256(contents.encode()).hexdigest()[:16]
