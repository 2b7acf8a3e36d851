"""Outputs that name inputs: every command with each of its outputs at the place of each of its inputs.

    python -m checks.outputs

Each pair is tried with the same path, a symbolic link and a hard link, with `--force` where the command has it. It must
end with status 2 and change no file. Options whose values look like files, and that are neither read nor
written according to `mossar_tools.places`, are named, too. The exit status is 1 if anything is wrong.
"""

import argparse
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Final, NamedTuple

from mossar_tools.cli import COMMANDS, command_called, main
from mossar_tools.parser import parser_of
from mossar_tools.places import READ, WRITTEN, WRITTEN_BY

_FILES: Final = ("FILE", "DIR", "SINK", "SOURCE", "RECORDING", "LABELS", "JOB", "IN", "OUT")
_NO_FILES: Final = {("archive", "target")}  # a folder of tables, beside which nothing is read
_CONTENT: Final = "repetitions = true\n"  # as a configuration, which is read first, it is sound
WAYS: Final = ("path", "symlink", "hard link")


class Case(NamedTuple):
    """A command whose output is at the place of an input.

    Args:
        command: Its name.
        read: Field of the input in the command's `Options`.
        written: Field of the output in the command's `Options`.
        arguments: Of the command, with `{in}` and `{out}` for both places.
    """

    command: str
    read: str
    written: str
    arguments: tuple[str, ...]


def unknown_options() -> list[str]:
    """Return options that look like files and are neither read nor written as far as the rule knows."""
    return [
        f"{command} {action.dest}"
        for command in COMMANDS
        for action in _actions(command)
        if str(action.metavar).partition(".")[0] in _FILES
        and action.dest not in {*READ, *WRITTEN, *WRITTEN_BY.get(command, ())}
        and (command, action.dest) not in _NO_FILES
    ]


def cases() -> Iterator[Case]:
    """Yield each command with each of its outputs and inputs."""
    for command in COMMANDS:
        own = WRITTEN_BY.get(command, ())
        actions = _actions(command)
        reading = [action for action in actions if action.dest in READ and action.dest not in own]
        writing = [action for action in actions if action.dest in WRITTEN or action.dest in own]
        for one in reading:
            for other in writing:
                if one.choices is None:
                    yield Case(command, one.dest, other.dest, _arguments(actions, one, other))


def wrong(case: Case, way: str) -> str:
    """Try a case; return its fault, empty if there is none.

    Args:
        case: The case.
        way: Way in which the output is the input: one of path, symlink, hard link.
    """
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "in.dat"), Path(folder, "out.dat")
        source.write_text(_CONTENT, encoding="utf-8")
        Path(folder, "other.dat").write_text(_CONTENT, encoding="utf-8")
        if way == "symlink":
            target.symlink_to(source)
        elif way == "hard link":
            os.link(source, target)
        else:
            target = source
        places = {"in": str(source), "out": str(target), "other": str(Path(folder, "other.dat"))}
        status = main([case.command, *(text.format_map(places) for text in case.arguments)])
        if source.read_text(encoding="utf-8") != _CONTENT:
            return "the input is replaced"
        return "" if status == 2 else f"status {status}"


def _actions(command: str) -> list[argparse.Action]:
    return parser_of(f"mossar {command}", command_called(command))._actions  # noqa: SLF001 - argparse has no other way


def _arguments(
    actions: list[argparse.Action], read: argparse.Action, written: argparse.Action
) -> tuple[str, ...]:
    """Return arguments with the input, the output, and the other needs of the command."""
    found = []
    for action in actions:
        value = "{in}" if action is read else "{out}" if action is written else "{other}"
        if not action.option_strings:
            found.append(value)
        elif action in (read, written):
            found += [action.option_strings[0], value]
    if any("--force" in action.option_strings for action in actions):
        found.append("--force")
    return tuple(found)


def _main() -> int:
    every = list(cases())
    found = [f"{option}: is it read or written?" for option in unknown_options()]
    found += [
        f"{case.command}: {case.written} at the place of {case.read}, {way}: {problem}"
        for case in every
        for way in WAYS
        if (problem := wrong(case, way))
    ]
    width = shutil.get_terminal_size().columns
    for line in found:
        print(line[:width])
    print(f"{len(every)} pairs of outputs and inputs, each in {len(WAYS)} ways; {len(found)} are wrong")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(_main())
