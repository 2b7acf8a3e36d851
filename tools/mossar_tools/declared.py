"""Declared: an option, stated once beside its type; parser, help, configuration and defaults are made from it.

A command has a record of its options, in the order of its help. Each field is an operand, an option, or a record of
options that several commands share::

    class Options(msgspec.Struct, frozen=True):
        sources: Annotated[tuple[str, ...], operand("SOURCE", "a URL or a recording", nargs="*")] = ()
        loop: Annotated[bool, Option("repeat until Ctrl-C")] = False
        page: PageOptions = PageOptions()

`options.page.port` is then the value of `--port`. Names of fields are different throughout a command.
"""

import argparse
from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

import msgspec


class Option(msgspec.Struct, frozen=True):
    """An option; one whose type is `bool` has no value.

    Args:
        help: Its text in the help.
        metavar: Name of its value; None shows the choices.
        convert: Returns the value of a text.
        flag: Long name without dashes; None for the name of the field, empty for an operand.
        choices: Legal values; those of a `Literal` without `convert` need not be repeated.
        nargs: Number of values if it is not one, as in `argparse`.
        const: The value of an option that is given without one.
        repeatable: Whether the option may be repeated; each occurrence adds a value.
    """

    help: str
    metavar: str | None = None
    convert: Callable[[str], Any] | None = None
    flag: str | None = None
    choices: tuple[str, ...] | None = None
    nargs: int | Literal["?", "*", "+"] | None = None
    const: str | None = None
    repeatable: bool = False


def operand(metavar: str, text: str, nargs: int | Literal["*", "+"] | None = None) -> Option:
    """Return an operand: a value without a flag."""
    return Option(text, metavar, nargs=nargs, flag="")


class Section(msgspec.Struct, frozen=True):
    """The heading in the help of a field and those after it; empty for the options without a heading."""

    title: str


class Declared(NamedTuple):
    """An option or operand of a command."""

    name: str  # of its field
    kind: Any  # type of its value
    flag: str  # long name without dashes, empty for an operand
    option: Option
    section: str  # title


def declared(record: type[msgspec.Struct], section: str = "") -> Iterator[Declared]:
    """Yield the options and operands of a record, and of the records in it, which begin in a section."""
    for name, kind, metas in _fields(record):
        section = next((meta.title for meta in metas if isinstance(meta, Section)), section)
        if _is_group(kind):
            yield from declared(kind, section)
        for option in (meta for meta in metas if isinstance(meta, Option)):
            flag = name.replace("_", "-") if option.flag is None else option.flag
            yield Declared(name, kind, flag, option, section)


def add_options(parser: argparse.ArgumentParser, record: type[msgspec.Struct]) -> None:
    """Add the options and operands of a command to its parser, which carries no defaults."""
    sections: dict[str, Any] = {"": parser}
    for one in declared(record):
        if one.section not in sections:
            sections[one.section] = parser.add_argument_group(one.section)
        told = {name: value for name, value in _told(one.kind, one.option).items() if value is not None}
        if one.flag:
            sections[one.section].add_argument(f"--{one.flag}", dest=one.name, **told)
        else:
            sections[one.section].add_argument(one.name, **told)


def _told(kind: Any, option: Option) -> dict[str, Any]:
    """Return the arguments of argparse for an option besides its name."""
    if bool in (kind, *get_args(kind)):
        action = "store_true" if kind is bool else argparse.BooleanOptionalAction
        return {"action": action, "help": option.help}
    literals = [part for part in (kind, *get_args(kind)) if get_origin(part) is Literal]
    words = [word for literal in literals for word in get_args(literal)]
    return {
        "action": "append" if option.repeatable else None,
        "metavar": option.metavar,
        "type": option.convert,
        "choices": option.choices or (words if words and option.convert is None else None),
        "nargs": option.nargs,
        "const": option.const,
        "default": argparse.SUPPRESS if option.nargs == "*" else None,  # None would require one
        "help": option.help,
    }


def nested(record: type[msgspec.Struct], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values by the names of their fields, those of a group in a mapping of its own."""
    found = {}
    for name, kind, _ in _fields(record):
        if _is_group(kind):
            found[name] = nested(kind, values)
        elif name in values:
            found[name] = values[name]
    return found


def values_of(options: msgspec.Struct) -> dict[str, Any]:
    """Return the values of all options by the names of their fields, those of groups beside the others."""
    found: dict[str, Any] = {}
    for name, value in msgspec.structs.asdict(options).items():
        found |= values_of(value) if isinstance(value, msgspec.Struct) else {name: value}
    return found


def _fields(record: type[msgspec.Struct]) -> Iterator[tuple[str, Any, list[Any]]]:
    """Yield name, type and metas of each field."""
    for name, hint in get_type_hints(record, include_extras=True).items():
        kind, *metas = get_args(hint) if get_origin(hint) is Annotated else (hint,)
        yield name, kind, metas


def _is_group(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, msgspec.Struct)
