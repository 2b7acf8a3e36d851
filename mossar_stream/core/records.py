"""Records: the numpy types of the core's structs, as the compiler laid them out."""

import re
from typing import Any

import numpy as np

# What Cython's description of a struct leaves out: how many records a member holds, and, for a record of two float64, which it
# describes as a complex number, the names of its members.
COUNTS = {"cycle": 32, "feet": 2}
PAIRS = {"tempo": ("spread", "squared_speed"), "bout": ("begin", "end")}
TOKENS = re.compile(
    r"(?:\((?P<shape>[\d,]+)\))?(?:(?P<open>T\{)|(?P<close>\})(?::(?P<of>\w+):)?|(?P<kind>Z?\w):(?P<name>\w+):)"
)


def record_type(struct: Any) -> np.dtype[Any]:
    """Return the numpy type of a struct.

    Args:
        struct: An array of one, as Cython makes it of a pointer.

    Raises:
        TypeError: If the description does not give the struct's size.
    """
    view = memoryview(struct)
    found = _parsed(view.format)
    if found.itemsize != view.itemsize:
        raise TypeError(f"{view.format} has {view.itemsize} bytes, not {found.itemsize}")
    return found


def _parsed(description: str) -> np.dtype[Any]:
    """Return the type that a description in the style of PEP 3118 gives."""
    if description == "Zd":
        return np.dtype([(name, "f8") for name in PAIRS["bout"]])
    levels: list[list[Any]] = [[]]
    for token in TOKENS.finditer(description):
        if token["open"]:
            levels.append([])
        elif token["close"]:
            record, name = np.dtype(levels.pop(), align=True), token["of"]
            levels[-1].append((name, record, COUNTS[name]) if name in COUNTS else (name or "", record))
        elif token["kind"] == "Zd":
            levels[-1].append((token["name"], [(name, "f8") for name in PAIRS[token["name"]]]))
        else:
            shape = tuple(map(int, token["shape"].split(","))) if token["shape"] else ()
            levels[-1].append((token["name"], token["kind"], shape))
    found: np.dtype[Any] = levels[0][0][1]
    return found
