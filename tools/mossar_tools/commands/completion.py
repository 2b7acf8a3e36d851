"""`mossar completion`: completion of commands and options by the Tab key."""

import argparse
from collections.abc import Mapping
from typing import Annotated, Any

import msgspec

from mossar_adapters.extras import needed
from mossar_tools.console import Console
from mossar_tools.declared import Option, add_options
from mossar_tools.errors import DONE
from mossar_tools.options import Messages

SHELLS = ("bash", "zsh", "tcsh")
_FILES = ("FILE", "SOURCE", "DIR", "JOB.toml", "FILE.toml", "IN", "OUT")  # arguments that may be paths

DESCRIPTION = "Print a script with which a shell completes the commands and options of mossar."
EXAMPLES = """  eval "$(mossar completion bash)"                                      in ~/.bashrc
  mossar completion zsh > _mossar                                       in a folder of $fpath
"""


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    target: Annotated[str, Option(", ".join(SHELLS), "SHELL", choices=SHELLS, flag="")]
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    needed("shtab", "completion", "mossar completion")
    import shtab

    console.line(shtab.complete(_parser(shtab.FILE), options.target).rstrip("\n"))
    return DONE


def _parser(files: Mapping[str, Any]) -> argparse.ArgumentParser:
    """Return one parser with all commands, as the library needs it."""
    from mossar_tools.cli import COMMANDS, command_called

    parser = argparse.ArgumentParser(prog="mossar")
    commands = parser.add_subparsers()
    for name, summary in COMMANDS.items():
        own = commands.add_parser(name, help=summary)
        add_options(own, command_called(name).Options)
        for action in own._actions:  # noqa: SLF001 - the library finds them in the same way
            if action.metavar in _FILES:
                action.complete = files  # type: ignore[attr-defined]
    return parser
