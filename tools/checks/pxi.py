"""Content of a Cython file: functions, constants, comments and docstrings; enough for checks, no parser.

The core's files keep to a few forms: functions and records begin at the left, constants stand in `cdef enum` or as
`cdef double NAME = value`.
"""

import re
from collections.abc import Iterator
from typing import NamedTuple

_HEAD = re.compile(
    r"^(?:cdef|cpdef|def) (?:inline )?(?:\([^)]*\) |\w[\w ]*\**\s+)?\**(\w+)\(([^()]*(?:\([^()]*\)[^()]*)*)\)"
    r"(?: (?:noexcept|except|->)[^:\n]*)?(?: nogil)?:$",
    re.MULTILINE,
)
_LEFT = re.compile(r"^[^\s#)]", re.MULTILINE)
_DOCSTRING = re.compile(r'"""(.*?)"""', re.DOTALL)
_COMMENT = re.compile(r"#.*")
_ENUM = re.compile(r"^cdef enum:(?: *#.*)?\n((?:(?: {4}.*)?\n)*)", re.MULTILINE)
_MEMBER = re.compile(r"^ {4}([A-Z]\w*) = ([^#\n]+)", re.MULTILINE)
_NUMBER = re.compile(r"^cdef (?:const )?(?:double|float|u?int64_t) ([A-Z]\w* = [^#\n]+)", re.MULTILINE)


class Function(NamedTuple):
    """A function: its first line, its name, its number of lines, and its parameters."""

    line: int
    name: str
    lines: int
    parameters: tuple[str, ...]


def functions(text: str) -> Iterator[Function]:
    """Yield the functions of a file."""
    for head in _HEAD.finditer(text):
        after = _LEFT.search(text, head.end())
        body = text[head.start() : after.start() if after else len(text)].rstrip()
        given = re.sub(r"\([^()]*\)", "", head[2])  # tuples of C have commas of their own
        parameters = tuple(part.strip() for part in given.split(",") if part.strip())
        yield Function(text.count("\n", 0, head.start()) + 1, head[1], body.count("\n") + 1, parameters)


def constants(text: str) -> Iterator[tuple[str, str]]:
    """Yield the names and the written values of constants."""
    code = _DOCSTRING.sub("", text)
    for members in _ENUM.findall(code):
        yield from ((name, value.strip()) for name, value in _MEMBER.findall(members))
    for declared in _NUMBER.findall(code):
        for one in re.split(r", (?=[A-Z]\w* = )", declared):
            name, _, value = one.partition(" = ")
            yield name, value.strip()


def words(text: str) -> list[str]:
    """Return the docstrings and comments."""
    return [*_DOCSTRING.findall(text), *_COMMENT.findall(_DOCSTRING.sub("", text))]


def names(text: str) -> set[str]:
    """Return all names in the code."""
    return set(re.findall(r"[A-Za-z_]\w*", _COMMENT.sub("", _DOCSTRING.sub("", text))))
