"""Cli: the program `mossar`.

Only the command that is asked for is imported, so that help and errors come at once.
"""

import argparse
import contextlib
import difflib
import errno
import importlib
import os
import sys
import traceback
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final, NoReturn, Protocol

import mossar_stream
from mossar_stream import MossarError
from mossar_tools.console import LOGGER, Console, console
from mossar_tools.errors import DONE, FAILED, INTERRUPTED, TERMINATED, WRONG_USAGE, Terminated, UsageError
from mossar_tools.signals import raising

if TYPE_CHECKING:
    from mossar_tools.options import Options

NO_ROOM = {errno.ENOSPC, errno.EFBIG, errno.EIO}
COMMANDS: Final[dict[str, str]] = {
    "demo": "a built-in performer streams through the whole pipeline; key frames appear live",
    "run": "segment live or recorded streams; JSON lines on standard output unless --to says otherwise",
    "segment": "a whole recording, offline: key frames, hierarchy; --json, --csv, --plot, --keep K",
    "teach": "teach moves that run --moves recognises: live, or from a recording; --list, --remove",
    "replay": "send a recording out as a live stream of frames",
    "record": "write arriving frames to a file that replay reproduces with its timing",
    "view": "the dashboard in a browser: a stream live, or a recording with its hierarchy",
    "webcam": "a page on which the browser's camera is the sensor; --get-model fetches the weights",
    "tune": "too many or too few key frames: their number at each strength, and suitable settings",
    "evaluate": "accuracy against labelled recordings, or demo:; --plot, --json",
    "agree": "agreement of two people, or of a person and the program, on labels; --plot, --json",
    "bench": "speed, delay and memory on this machine; --json, --plot",
    "flink": "live streams of many performers on Apache Flink, described by a TOML file",
    "archive": "a folder or bucket of recordings into Parquet tables, on Ray Data; --resume continues",
    "settings": "the value of each setting, its unit, and its effect",
    "schema": "the JSON Schema of the events",
    "completion": "completion by the Tab key, for bash, zsh and tcsh",
    "adapters": "readable and writable formats, missing extras; --check URL",
}

_EPILOG = """examples:
  mossar demo                                  watch key frames of the built-in performer
  mossar run osc://0.0.0.0:39539               segment what a VMC or Kinect program sends
  mossar segment walk.bvh --plot walk.png      one picture of a recording
  mossar view demo:                            see the motion, and move the level live

mossar COMMAND --help explains a command.
"""


class Command(Protocol):
    """A module that is a program's command."""

    DESCRIPTION: str
    EXAMPLES: str

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Add the arguments of this command."""

    def run(self, options: "Options", console: Console) -> int:
        """Run the command and return the exit status."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run `mossar` and return its exit status.

    Args:
        argv: Arguments after the program's name; None for those of the process.
    """
    arguments = sys.argv[1:] if argv is None else list(argv)
    return guarded(lambda terminal: _run(arguments, terminal))


def _open_closed_streams() -> None:
    """Give standard streams that were closed (`>&-`) to nowhere, which takes their descriptors before a socket does."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open(mode, encoding="utf-8"))  # noqa: SIM115 - for good


def guarded(program: Callable[[Console], int]) -> int:
    """Run a program and return its exit status: errors become one line, signals the status that is usual for them.

    Args:
        program: Gets the console and returns its status.
    """
    _open_closed_streams()
    terminal = console()
    terminal.set_up("info", as_json=False, status=True)
    try:
        with raising():
            status = program(terminal)
            terminal.clear()
            terminal.out.flush()
    except BrokenPipeError:
        _leave_standard_output()
        return DONE
    except KeyboardInterrupt:
        terminal.clear()
        return INTERRUPTED
    except Terminated:
        terminal.clear()
        return TERMINATED
    except MossarError as error:
        from mossar_adapters.files.output import OutputError

        LOGGER.error("%s", error)
        return FAILED if isinstance(error, OutputError) else WRONG_USAGE
    except ImportError as error:
        if not (error.name or "").startswith("mossar_stream.core"):
            raise
        LOGGER.error("%s", error)  # the compiled core is missing, or MOSSAR_CORE names none
        return WRONG_USAGE
    except OSError as error:
        if error.filename is None and error.errno in NO_ROOM:
            _leave_standard_output()
            LOGGER.error("standard output cannot be written: %s", error.strerror)
        else:
            _report_defect(error)
        return FAILED
    except Exception as error:  # noqa: BLE001 - the last resort: one line, and the traceback on request
        _report_defect(error)
        return FAILED
    return status


class Parser(argparse.ArgumentParser):
    """Reports wrong usage as one line."""

    def error(self, message: str) -> NoReturn:
        """Raise what is wrong instead of ending the program."""
        unknown = message.rpartition("unrecognized arguments: ")[2].split(" ")[0].partition("=")[0]
        known = self._option_string_actions if message.startswith("unrecognized") else ()
        if message.startswith("the following"):
            message += f"; try {first_example(self.epilog or '')}"
        raise UsageError(f"{message}{did_you_mean(unknown, known)} (see {self.prog} --help)")


def first_example(epilog: str) -> str:
    r"""Return the first command of a help's examples, without its comment.

    Example:
        >>> first_example("examples:\n  mossar evaluate demo:      without any data\n")
        'mossar evaluate demo:'
    """
    return epilog.partition("\n")[2].strip().splitlines()[0].partition("   ")[0]


def did_you_mean(wrong: str, right: Iterable[str]) -> str:
    """Return a question that names what may have been meant, or nothing.

    Example:
        >>> did_you_mean("segmnt", ["run", "segment"])
        ' - did you mean segment?'
    """
    near = difflib.get_close_matches(wrong, list(right), 1)
    return f" - did you mean {near[0]}?" if near else ""


def run_command(prog: str, command: Command, arguments: Sequence[str], terminal: Console) -> int:
    """Parse the arguments of a command, run it, and return its exit status.

    Args:
        prog: What the user typed to get here.
        command: What to run.
        arguments: After the command's name.
        terminal: Where words go.

    Raises:
        MossarError: If something is wrong with the arguments, or what they name.
    """
    from mossar_tools.options import parse
    from mossar_tools.places import check_command

    parser = parser_of(prog, command)
    try:
        options = parse(parser, arguments)
    except SystemExit:  # --help
        return DONE
    level = options.log_level or ("error" if options.quiet else "debug" if options.verbose else "info")
    terminal.set_up(level, as_json=options.log_json, status=not options.quiet)
    check_command(prog.rsplit(maxsplit=1)[-1], options)
    return command.run(options, terminal)


def parser_of(prog: str, command: Command) -> Parser:
    """Return the parser of a command."""
    parser = Parser(
        prog=prog,
        description=command.DESCRIPTION,
        epilog=f"examples:\n{command.EXAMPLES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        argument_default=argparse.SUPPRESS,
        allow_abbrev=False,
    )
    command.add_arguments(parser)
    return parser


def command_called(name: str) -> Command:
    """Return the command of that name.

    Raises:
        UsageError: If there is none.
    """
    if name not in COMMANDS:
        raise UsageError(
            f"no command called {name[:40]!r}{did_you_mean(name, COMMANDS)}; there are {', '.join(COMMANDS)}"
        )
    command: Command = importlib.import_module(f"mossar_tools.commands.{name}")
    return command


def _run(arguments: list[str], terminal: Console) -> int:
    # What stands before the command's name can only be --help or --version.
    if not arguments or arguments[0].startswith("-"):
        return _run_without_command(arguments or ["--help"], terminal)
    name = arguments[0]
    return run_command(f"mossar {name}", command_called(name), arguments[1:], terminal)


def _run_without_command(arguments: list[str], terminal: Console) -> int:
    parser = Parser(
        prog="mossar",
        description="Find, live, where one human motion ends and the next begins.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        usage="mossar COMMAND [options]",
    )
    parser.add_argument("-V", "--version", action="store_true", help="print the version and stop")
    commands = parser.add_argument_group("commands")
    for name, summary in COMMANDS.items():
        commands.add_argument(name, help=summary, nargs="?")
    try:
        found = parser.parse_args(arguments)
    except SystemExit:
        return DONE
    if found.version:
        terminal.line(f"mossar-stream {mossar_stream.__version__}")
        return DONE
    raise UsageError(f"which command? There are {', '.join(COMMANDS)} (see mossar --help)")


def _leave_standard_output() -> None:
    """Discard the interpreter's last flush: standard output is closed."""
    with contextlib.suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def _report_defect(error: Exception) -> None:
    text = " ".join(str(error).split())
    LOGGER.error(
        "internal error, please report it: %s: %s (--verbose shows where)", type(error).__name__, text
    )
    for line in traceback.format_exception(error):
        LOGGER.debug("%s", line.rstrip())
