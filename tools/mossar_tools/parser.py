"""Parser: the options of a command, help of one screen, and an answer to each wrong line."""

import argparse
import difflib
import itertools
import sys
from collections.abc import Iterable, Sequence
from typing import Any, Final, NoReturn, Protocol

import msgspec

from mossar_tools.declared import add_options, declared
from mossar_tools.errors import UsageError

FEW: Final = 5  # examples of the short help
_OUTPUTS: Final = ("--csv", "--json", "--plot", "--to")
# Likely names of options that have other names; messages name those that the command has.
_MEANT: Final[dict[str, tuple[str, ...]]] = {
    "-o": _OUTPUTS,
    "--out": _OUTPUTS,
    "--output": _OUTPUTS,
    "--format": _OUTPUTS,
    "-q": ("--quiet",),
    "-v": ("--verbose", "--version"),
    "--threshold": ("--set sig_threshold=0.05",),
}
_SOURCE: Final = ("-i", "-p", "--in", "--input", "--source", "--file")


class Declares(Protocol):
    """The declarations of a command; `COMMON`, the options of its short help, is optional."""

    DESCRIPTION: str
    EXAMPLES: str
    Options: type[msgspec.Struct]


class Parser(argparse.ArgumentParser):
    """Reports wrong usage as one line. Its help shows the common options; `--help-all` shows all.

    Args:
        common: Long names of the options that the short help shows; all of them if it is empty.
        short: Epilog of the short help.
        options: Of `argparse.ArgumentParser`.
    """

    def __init__(self, *, common: Sequence[str] = (), short: str = "", **options: Any) -> None:
        super().__init__(**options)
        self._common = frozenset(common)
        self._short = short
        self._given: list[str] = []  # the parsed arguments
        if common:
            self.add_argument(
                "--help-all",
                action=_HelpAll,
                default=argparse.SUPPRESS,
                help="show all options and examples, and exit",
            )

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Keep the parsed arguments, for messages."""
        self._given = list(sys.argv[1:] if args is None else args)
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        """Raise the error instead of ending the program."""
        name = message.removeprefix("argument ").partition(":")[0].partition("/")[0]
        if message.startswith("unrecognized"):
            message = self._unknown(message)
        elif message.startswith("the following"):
            message += f"; try {first_example(self.epilog or '')}"
        elif message.endswith("argument") and name in self._option_string_actions:
            action = self._option_string_actions[name]
            message += f": {name} {action.metavar or ''} ({action.help})"
        raise UsageError(f"{message} (see {self.prog} --help)")

    def format_help(self) -> str:
        """Return the short help, if the command has one: its common options, each in a few words."""
        if not self._common:
            return super().format_help()
        before = [(action, action.help) for action in self._actions], self.epilog, self.usage
        for action in self._actions:
            action.help = self._short_help(action)
        self.usage = f"{self.prog} {' '.join(self._operands())} [options]".replace("  ", " ")
        self.epilog = self._short
        try:
            return super().format_help()
        finally:
            helps, self.epilog, self.usage = before
            for action, text in helps:
                action.help = text

    def _short_help(self, action: argparse.Action) -> str | None:
        if isinstance(action, _HelpAll) or not action.option_strings:
            return action.help
        if not self._common.intersection(action.option_strings):
            return argparse.SUPPRESS
        return (action.help or "").partition("; ")[0]

    def format_whole_help(self) -> str:
        """Return the help with all options."""
        return super().format_help()

    def _operands(self) -> list[str]:
        found = [action for action in self._actions if not action.option_strings]
        return [f"{action.metavar}{'...' if action.nargs in {'*', '+'} else ''}" for action in found]

    def _unknown(self, message: str) -> str:
        """Return a message about arguments that the command does not have."""
        first = message.rpartition("unrecognized arguments: ")[2].split(" ")[0].partition("=")[0]
        if not first.startswith("-"):
            return f"{message}; {self._without_value(first) or f'{self.prog} takes {self._taken()}'}"
        if first in _SOURCE and (operands := self._operands()):
            return f"{message}; {operands[-1].removesuffix('...')} stands without an option: {first_example(self.epilog or '')}"
        known = self._meant(first) or self._setting(first) or _elsewhere(first, self.prog)
        return f"{message}{known or did_you_mean(first, self._option_string_actions)}"

    def _meant(self, option: str) -> str:
        """Return the options of this command that are called otherwise, or nothing."""
        own = [name for name in _MEANT.get(option, ()) if name.split(" ")[0] in self._option_string_actions]
        shown = own if own == ["--to"] else [name for name in own if name != "--to"]
        return f" - did you mean {' or '.join(shown)}?" if own else ""

    def _setting(self, option: str) -> str:
        """Return the form of a setting that was typed as an option, or nothing."""
        from mossar_stream import Settings

        name = option.lstrip("-").replace("-", "_")
        if name not in Settings.__struct_fields__ or "--set" not in self._option_string_actions:
            return ""
        return f" - did you mean --set {name}=VALUE?"

    def _without_value(self, value: str) -> str:
        """Return the option without a value that stands before an unknown value; else nothing."""
        for before, given in itertools.pairwise(self._given):
            action = self._option_string_actions.get(before)
            if given == value and action is not None and action.nargs == 0:
                return f"{before} takes no value"
        return ""

    def _taken(self) -> str:
        operands = self._operands()
        return f"{' '.join(operands)} and options" if operands else "options only"


class _HelpAll(argparse.Action):
    def __init__(self, option_strings: Sequence[str], dest: str, default: Any, **options: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, default=default, **options)

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        print(parser.format_whole_help() if isinstance(parser, Parser) else parser.format_help(), end="")
        parser.exit()


def _elsewhere(option: str, prog: str) -> str:
    """Return the commands that have an option that this one lacks, or nothing."""
    from mossar_tools.cli import COMMANDS, command_called

    own = prog.rpartition(" ")[2]
    having = (
        name
        for name in COMMANDS
        if any(f"--{one.flag}" == option for one in declared(command_called(name).Options))
    )
    found = [f"mossar {name}" for name in having] if own in COMMANDS else []
    return f"; {option} is an option of {', '.join(found[:4])}" if found else ""


def first_example(epilog: str) -> str:
    r"""Return the first command of a help's examples, without its comment.

    Example:
        >>> first_example("examples:\n  mossar evaluate demo:      without any data\n")
        'mossar evaluate demo:'
    """
    return epilog.partition("\n")[2].strip().splitlines()[0].partition("   ")[0]


def did_you_mean(wrong: str, right: Iterable[str], *, alike: float = 0.6) -> str:
    """Return a question that names the likely word, or nothing.

    Args:
        wrong: The typed word.
        right: The known words.
        alike: Least similarity of the two, from 0 to 1.

    Example:
        >>> did_you_mean("segmnt", ["run", "segment"])
        ' - did you mean segment?'
    """
    near = difflib.get_close_matches(wrong.lower(), list(right), 1, alike)
    return f" - did you mean {near[0]}?" if near else ""


def parser_of(prog: str, command: Declares) -> Parser:
    """Return the parser of a command."""
    lines = command.EXAMPLES.splitlines()
    parser = Parser(
        common=getattr(command, "COMMON", ()),
        short="\n".join(["examples:", *lines[:FEW]]),
        prog=prog,
        description=command.DESCRIPTION,
        epilog=f"examples:\n{command.EXAMPLES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        argument_default=argparse.SUPPRESS,
        allow_abbrev=False,
    )
    add_options(parser, command.Options)
    return parser
