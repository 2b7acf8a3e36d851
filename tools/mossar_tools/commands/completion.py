"""`mossar completion`: completion of commands and options by the Tab key."""

import argparse
from collections.abc import Mapping
from typing import Any

from mossar_adapters.extras import needed
from mossar_tools.console import Console
from mossar_tools.errors import DONE
from mossar_tools.options import Options, add_messages

SHELLS = ("bash", "zsh", "tcsh")
_FILES = ("FILE", "SOURCE", "DIR", "JOB.toml", "FILE.toml", "IN", "OUT")  # arguments that may be paths

DESCRIPTION = "Print a script with which a shell completes the commands and options of mossar."
EXAMPLES = """  eval "$(mossar completion bash)"                                      in ~/.bashrc
  mossar completion zsh > _mossar                                       in a folder of $fpath
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    parser.add_argument("target", metavar="SHELL", choices=SHELLS, help=", ".join(SHELLS))
    add_messages(parser)


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    needed("shtab", "completion", "mossar completion")
    import shtab

    console.line(shtab.complete(_parser(shtab.FILE), options.target).rstrip("\n"))
    return DONE


def _parser(files: Mapping[str, Any]) -> argparse.ArgumentParser:
    """Return one parser with all commands, as the library wants it."""
    from mossar_tools.cli import COMMANDS, command_called

    parser = argparse.ArgumentParser(prog="mossar")
    commands = parser.add_subparsers()
    for name, summary in COMMANDS.items():
        own = commands.add_parser(name, help=summary)
        command_called(name).add_arguments(own)
        for action in own._actions:  # noqa: SLF001 - how the library finds them, too
            if action.metavar in _FILES:
                action.complete = files  # type: ignore[attr-defined]
    return parser
