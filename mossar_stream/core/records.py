"""Records: the numpy types of the core's structs, read off their declarations, with the compiler's sizes as proof."""

import re
from functools import cache
from typing import Any

import numpy as np

NUMBER_TYPES = {
    "double": "f8",
    "float": "f4",
    "int8_t": "i1",
    "int16_t": "i2",
    "int32_t": "i4",
    "int64_t": "i8",
    "uint8_t": "u1",
    "uint64_t": "u8",
}


def record_types(declared: str, sizes: dict[str, int]) -> dict[str, np.dtype[Any]]:
    """Return the numpy types of structs, laid out by C's rules of alignment.

    Args:
        declared: A line for each struct, such as `Foot int64_t points[4]; float places[256][4][3]`; see build_core/sources.py.
        sizes: Of the wanted structs, bytes, as the compiler laid them out.

    Raises:
        TypeError: The compiler laid out a struct in another way.
        KeyError: A struct is not declared, or has a member that is no number and no record.
    """
    members = {name: text for name, _, text in (line.partition(" ") for line in declared.splitlines())}

    @cache
    def record(name: str) -> np.dtype[Any]:
        return np.dtype([member(*text.split(" ")) for text in members[name].split("; ")], align=True)

    def member(kind: str, name: str) -> tuple[str, Any, tuple[int, ...]]:
        shape = tuple(map(int, re.findall(r"\[(\d+)\]", name)))
        return name.partition("[")[0], NUMBER_TYPES.get(kind) or record(kind), shape

    found = {name: record(name) for name in sizes}
    for name, size in sizes.items():
        if found[name].itemsize != size:
            raise TypeError(f"{name} has {size} bytes, not {found[name].itemsize}")
    return found
