"""Hints: the options with which messages can be read that no profile wants, built from those that arrived."""

import math
from collections import Counter, deque
from collections.abc import Collection, Sequence
from itertools import groupby, pairwise
from typing import Any, Final
from urllib.parse import quote

import msgspec

from mossar_adapters.osc.profiles.profile import Message

_KEPT: Final = 512  # messages
_LONGEST: Final = 256  # characters of an address
_ARGUMENTS: Final = 16  # of a message that are compared
_FEWEST: Final = 3  # joints, and numbers of one
_FLAT: Final = 9  # numbers that may be a whole pose
_MOST_PEOPLE: Final = 16
_UNIT: Final = 1e-3  # by which the square of a quaternion may differ from 1
_SEPARATORS: Final = "_-.: "
_SAFE: Final = "/{}_-.:,*"


class _Seen(msgspec.Struct):
    parts: tuple[str, ...]  # of the address, between slashes
    arguments: tuple[Any, ...]  # the first ones
    count: int  # of all arguments

    @property
    def kind(self) -> tuple[int, str, int]:
        """The common part of messages of one kind: depth of the address, types and number of arguments."""
        return len(self.parts), "".join(map(_letter, self.arguments)), self.count


class Hints:
    """Keeps the latest messages that no profile wants, and proposes options for them.

    Example:
        >>> hints = Hints()
        >>> for joint in ("Head", "Neck", "Hand"):
        ...     hints.add(Message(f"/tracker/{joint}", (0.1, 1.6, 0.2), "", 0.0))
        >>> hints.options()
        'profile=generic&pattern=/tracker/{joint}&args=xyz'
    """

    def __init__(self) -> None:
        self._seen: deque[_Seen] = deque(maxlen=_KEPT)

    def add(self, message: Message) -> None:
        """Note a message that no profile wants."""
        if len(message.address) <= _LONGEST:
            first = tuple(message.arguments[:_ARGUMENTS])
            self._seen.append(_Seen(tuple(message.address.split("/")), first, len(message.arguments)))

    def options(self) -> str | None:
        """Return the options of a URL that read the most frequent messages, None if they hold no positions."""
        latest = self._seen.copy()  # at once: another thread adds
        kinds = Counter(seen.kind for seen in latest)
        for kind, _ in kinds.most_common():
            found = _options([seen for seen in latest if seen.kind == kind])
            if found is not None:
                return found
        return None


def _options(alike: Sequence[_Seen]) -> str | None:
    """Return options for messages of one kind."""
    texts = alike[0].kind[1]
    if texts.count("n") + texts.count("i") < _FEWEST:
        return None
    varied = [
        i for i, part in enumerate(zip(*(seen.parts for seen in alike), strict=True)) if len(set(part)) > 1
    ]
    letters = _letters(alike, named=not varied)
    if letters is None:
        return _flat(alike) if not varied and "s" not in texts else None
    pattern = _pattern(alike, varied, letters)
    return None if pattern is None else f"profile=generic&pattern={quote(pattern, _SAFE)}&args={letters}"


def _flat(alike: Sequence[_Seen]) -> str | None:
    """Return options for messages with all numbers of a pose."""
    count = alike[0].count
    stride = next((width for width in (3, 4) if count % width == 0), 0)
    return f"profile=flat&stride={stride}" if stride and count >= _FLAT else None


def _pattern(alike: Sequence[_Seen], varied: Sequence[int], letters: str) -> str | None:
    """Return the address with placeholders for its varying parts."""
    parts = list(alike[0].parts)
    distinct = {i: len({seen.parts[i] for seen in alike}) for i in varied}
    joint = None if "j" in letters else max(varied, key=lambda i: (distinct[i], i))
    for i in varied:
        if i != joint and "p" in letters:
            return None  # two words for the performer
        parts[i] = _around([seen.parts[i] for seen in alike], "{joint}" if i == joint else "{performer}")
    return None if "/".join(parts).count("{performer}") > 1 else "/".join(parts)


def _around(values: Sequence[str], placeholder: str) -> str:
    """Return the placeholder behind the common begin of all values, up to a separator: `skeleton_{joint}`."""
    shared = min(values)
    while shared and not all(value.startswith(shared) and len(value) > len(shared) for value in values):
        shared = shared[:-1]
    return shared[: max(shared.rfind(mark) for mark in _SEPARATORS) + 1] + placeholder


def _letters(alike: Sequence[_Seen], *, named: bool) -> str | None:
    """Return the option `args` for the arguments; None if they lack a place or, where it must be, a name.

    Args:
        alike: Messages of one kind.
        named: Whether the name of the joint must be among the arguments.
    """
    columns = list(zip(*(seen.arguments for seen in alike), strict=True))
    letters = ["_"] * len(columns)
    turns = _turns(columns)
    place = _place(columns, turns)
    if place is None or (alike[0].count >= _FLAT and all(_letter(column[0]) == "n" for column in columns)):
        return None
    letters[place : place + 3] = "xyz"
    if named:
        joint = _joint(columns)
        if joint is None:
            return None
        letters[joint] = "j"
    person = [i for i in range(place) if letters[i] == "_" and _is_person(columns[i])]
    if person:
        letters[person[-1]] = "p"
    after = place + 3
    if after < len(columns) and after not in turns and _is_share(columns[after]):
        letters[after] = "c"
    return "".join(letters).rstrip("_")


def _place(columns: Sequence[Sequence[Any]], turns: Collection[int]) -> int | None:
    """Return the place of three coordinates: floats if there are three in a row, else other numbers.

    Args:
        columns: Arguments of messages of one kind.
        turns: Those that are quaternions.
    """
    clocks = {i for i, column in enumerate(columns) if _is_clock(column)}
    for letters in ("n", "ni"):
        for others in ({*turns, *clocks}, turns, ()):
            for i in range(len(columns) - 2):
                if all(_letter(columns[k][0]) in letters and k not in others for k in (i, i + 1, i + 2)):
                    return i
    return None


def _turns(columns: Sequence[Sequence[Any]]) -> set[int]:
    """Return the columns that are quaternions: four numbers whose squares add up to one in every message."""
    found: set[int] = set()
    for i in range(len(columns) - 3):
        four = columns[i : i + 4]
        if all(_letter(column[0]) in "ni" for column in four) and all(
            abs(sum(value * value for value in row) - 1) < _UNIT for row in zip(*four, strict=True)
        ):
            found |= set(range(i, i + 4))
    return found


def _joint(columns: Sequence[Sequence[Any]]) -> int | None:
    """Return the place of a joint's name: a text, or else a whole number of many that come again."""
    texts = [i for i, column in enumerate(columns) if isinstance(column[0], str)]
    joint = max(texts, key=lambda i: len(set(columns[i])), default=None)
    if joint is not None:
        return joint if len(set(columns[joint])) >= _FEWEST else None
    numbers = [i for i, column in enumerate(columns) if _letter(column[0]) == "i" and _comes_again(column)]
    joint = max(numbers, key=lambda i: len(set(columns[i])), default=None)
    return joint if joint is not None and len(set(columns[joint])) >= _FEWEST else None


def _comes_again(column: Sequence[Any]) -> bool:
    """Return whether the values of a column come again in turns, unlike those of a counter."""
    return sum(1 for _ in groupby(column)) > len(set(column))


def _is_clock(column: Sequence[Any]) -> bool:
    """Return whether a column may be a time: a number that several messages share, and that never falls."""
    values = [value for value in column if isinstance(value, int | float)]
    rises = all(one <= other for one, other in pairwise(values))
    return len(values) == len(column) and rises and 1 < len(set(values)) <= len(values) / 2


def _is_person(column: Sequence[Any]) -> bool:
    """Return whether a column may name the performer of a joint: few whole numbers or words, which come again, unlike counters."""
    values = set(column)
    whole = all(isinstance(value, int | str) for value in column)
    return whole and len(values) <= _MOST_PEOPLE and (len(values) == 1 or _comes_again(column))


def _is_share(column: Sequence[Any]) -> bool:
    return all(isinstance(value, int | float) and 0 <= value <= 1 for value in column)


def _letter(value: Any) -> str:
    """Return the type of an argument: `s` text, `i` whole number, `n` other number, `?` something else."""
    if isinstance(value, bool):
        return "?"
    if isinstance(value, str):
        return "s"
    if isinstance(value, int):
        return "i"
    return "n" if isinstance(value, float) and not math.isinf(value) else "?"
