"""Mutation: real samples, damaged at random."""

import random
import re
import struct
from collections.abc import Sequence

LONGEST = 1 << 16  # bytes; longer input is cut

_EDGES = tuple(
    struct.pack(order + kind, value)
    for order in "<>"
    for kind, value in (
        ("i", -1),
        ("i", 0),
        ("i", 2**31 - 1),
        ("i", -(2**31)),
        ("i", 1 << 20),
        ("f", float("nan")),
        ("f", float("inf")),
        ("f", 3e38),
        ("d", float("nan")),
        ("d", -float("inf")),
        ("d", 1e300),
        ("q", 2**63 - 1),
    )
)
_WORDS = (
    *(b"-1", b"0", b"99999999999", b"1e308", b"-1e-320", b"nan", b"-inf", b"", b"abc", b"\xe9", b"9" * 300),
    *(b"{", b"]", b'"', b"null", b"true", b"\\", b"\r\n", b"\0", b",", b"%00", b"\xf0\x9f\x92\x83"),
)
_TOKEN = re.compile(rb"[A-Za-z0-9_.+-]+")


class Mutator:
    """Yields damaged samples.

    Args:
        rng: Source of chance.
        samples: Input to damage.
        words: Words to insert, beside the usual troublemakers.
    """

    def __init__(self, rng: random.Random, samples: Sequence[bytes], words: Sequence[bytes] = ()) -> None:
        self._rng = rng
        self._samples = samples
        self._words = (*_WORDS, *words)

    def next(self) -> bytes:
        """Return a sample with up to four places damaged; one in ten is whole, one in fifty is noise."""
        rng = self._rng
        luck = rng.random()
        if luck < 0.02:
            return rng.randbytes(int(rng.random() * 200))
        data = self._any(self._samples)
        if luck < 0.12:
            return data
        for _ in range(1 + int(rng.random() * rng.random() * 5)):
            data = self._damaged(data)
        return data[:LONGEST]

    def _any(self, things: Sequence[bytes]) -> bytes:
        return things[int(self._rng.random() * len(things))]

    def _damaged(self, data: bytes) -> bytes:
        rng = self._rng
        at = int(rng.random() * (len(data) + 1))
        if rng.random() < 0.3:
            at = min(at, int(rng.random() * 80))  # headers matter most
        match int(rng.random() * 9):
            case 0:
                return data[:at] + bytes((int(rng.random() * 256),)) + data[at + 1 :]
            case 1:
                at &= ~3  # binary formats align their numbers
                edge = self._any(_EDGES)
                return data[:at] + edge + data[at + len(edge) :]
            case 2:
                return data[:at] + data[at + 1 + int(rng.random() * 40) :]
            case 3:
                return data[:at]
            case 4:
                return data[:at] + data[max(0, at - int(rng.random() * 100)) :]
            case 5:
                return data[:at] + self._any(self._words) + data[at:]
            case 6:
                other = self._any(self._samples)
                return data[:at] + other[int(rng.random() * len(other)) :]
            case 7:
                return data[:at] + self._any(_EDGES) + data[at:]
            case _:
                return self._reworded(data, at)

    def _reworded(self, data: bytes, at: int) -> bytes:
        """Return data with the next word replaced by another."""
        found = _TOKEN.search(data, at, at + 200)
        if found is None:
            return data
        return data[: found.start()] + self._any(self._words) + data[found.end() :]
