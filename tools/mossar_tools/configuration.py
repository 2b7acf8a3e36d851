"""Configuration: the options of the command line in a TOML file.

Keys are the long options without dashes; lists are for options that may be repeated. There are two more keys: `sources`,
the list of sources if the command line names none, and the table `[settings]` for `--set`. A command ignores options that
it does not have, so that one file serves several commands::

    preset = "game"
    to = ["osc://127.0.0.1:9000", "events.jsonl"]

    [settings]
    sig_threshold = 0.04
"""

import argparse
from pathlib import Path
from typing import Any

from mossar_adapters.toml_file import read_toml
from mossar_stream import MossarError
from mossar_tools.declared import declared
from mossar_tools.errors import UsageError
from mossar_tools.parser import did_you_mean

_ELSEWHERE = {"set", "config", "check"}  # have another name in a file, or are not allowed there
_NOT_HERE = ("plot_to",)  # --to of a picture; `to` in a file is a sink


def read_configuration(path: Path, parser: argparse.ArgumentParser) -> dict[str, Any]:
    """Return the option values in a file, by the names of their fields.

    Args:
        path: TOML file.
        parser: Parser of the command; it checks and converts the values.

    Raises:
        UsageError: If the file cannot be read, or a key or value is impossible.
    """
    content = read_toml(path, "configuration", UsageError)
    settings = content.pop("settings", {})
    sources = content.pop("sources", [])
    if not isinstance(settings, dict):
        raise UsageError(f"{path}: settings must be a table: [settings]")
    if not isinstance(sources, list) or not all(isinstance(source, str) for source in sources):
        raise UsageError(f"{path}: sources must be a list of texts")
    found: dict[str, Any] = {"set": _flattened(settings)}
    actions = {name: action for action in parser._actions for name in action.option_strings}  # noqa: SLF001
    names = known_names()
    for key, value in content.items():
        option = "--" + key.replace("_", "-")
        if key.replace("-", "_") not in names:
            known = did_you_mean(key, sorted(names), alike=0.7) or f"; there are {', '.join(sorted(names))}"
            raise UsageError(f"{path}: there is no option {key!r}{known}")
        if option in actions and actions[option].dest not in _NOT_HERE:
            found[actions[option].dest] = _converted(path, key, value, actions[option])
    if sources and any(action.dest == "sources" for action in parser._actions):  # noqa: SLF001
        found["sources"] = sources
    return found


def known_names() -> set[str]:
    """Return the keys that a file may have: the options of all commands, the sources and the settings."""
    from mossar_tools.cli import COMMANDS, command_called

    flags = {one.flag for name in COMMANDS for one in declared(command_called(name).Options)}
    return {flag.replace("-", "_") for flag in flags if flag} - _ELSEWHERE | {"sources", "settings"}


def _converted(path: Path, key: str, value: Any, action: argparse.Action) -> Any:
    """Return a value, checked and converted by its option."""
    if action.nargs == 0:
        if not isinstance(value, bool):
            raise UsageError(f"{path}: {key} must be true or false, not {value!r}")
        return value
    if action.nargs == "?" and value is True:
        return action.const
    if isinstance(action.nargs, int):
        parts = value.split() if isinstance(value, str) else value
        if not isinstance(parts, list) or len(parts) != action.nargs:
            raise UsageError(
                f"{path}: {key} must be {action.nargs} texts, each {action.metavar}, not {value!r}"
            )
        return [_one(path, key, part, action) for part in parts]
    several = isinstance(action, argparse._AppendAction)  # noqa: SLF001 - argparse has no public test for it
    if isinstance(value, list) and not several:
        value = ",".join(str(part) for part in value)
    values = value if isinstance(value, list) else [value]
    converted = [_one(path, key, part, action) for part in values]
    return converted if several else converted[0]


def _one(path: Path, key: str, value: Any, action: argparse.Action) -> Any:
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise UsageError(f"{path}: {key} cannot be {str(value)[:40]}")
    text = str(value)
    try:
        result = action.type(text) if callable(action.type) else text
    except (argparse.ArgumentTypeError, ValueError, MossarError) as error:
        raise UsageError(f"{path}: {key}: {error}") from None
    if action.choices is not None and result not in action.choices:
        raise UsageError(f"{path}: {key} must be one of {', '.join(map(str, action.choices))}, not {text!r}")
    return result


def _flattened(settings: dict[str, Any]) -> dict[str, Any]:
    """Return nested tables as dotted names: `features.positions`."""
    flat: dict[str, Any] = {}
    for name, value in settings.items():
        if isinstance(value, dict):
            flat.update({f"{name}.{part}": inner for part, inner in value.items()})
        else:
            flat[name] = value
    return flat
