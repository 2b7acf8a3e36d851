"""Cli: the program `mossar`.

Only the wanted command is imported, so that help and errors come at once.
"""

import argparse
import contextlib
import errno
import importlib
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final, Protocol

import mossar_stream
from mossar_stream import MossarError
from mossar_tools.console import LOGGER, Console, console
from mossar_tools.errors import DONE, FAILED, INTERRUPTED, TERMINATED, WRONG_USAGE, Terminated, UsageError
from mossar_tools.parser import Declares, Parser, did_you_mean, parser_of
from mossar_tools.signals import raising

NO_ROOM = {errno.ENOSPC, errno.EFBIG, errno.EIO}
COMMANDS: Final[dict[str, str]] = {
    "demo": "show a built-in performer and its key frames",
    "run": "segment live or recorded streams, and send events to programs",
    "segment": "segment recordings into a table, .csv, .json or a picture",
    "view": "watch a stream or a recording in a browser",
    "teach": "show moves that are recognised, followed and counted later",
    "settings": "print the value of each setting, its unit and its effect",
    "tune": "suggest a strength from the number of key frames, or from labels",
    "evaluate": "score key frames on labelled recordings, or demo:",
    "agree": "compare the labels of two people, or of a person and the program",
    "archive": "segment a folder of recordings into Parquet tables, on Ray Data",
    "bench": "measure speed, delay and memory on this machine",
    "replay": "send a recording as a live stream of frames",
    "record": "write arriving frames to a file for replay",
    "adapters": "list formats, protocols and missing extras; --check URL tries one; fetch weights",
    "flink": "segment live streams of many performers on Apache Flink",
    "schema": "print the JSON Schema of the events",
    "completion": "print a script for the Tab key, for bash, zsh and tcsh",
    "webcam": "open the page of mossar view webcam:browser, under its former name",
}
# Commands for which a port alone is a source or sink.
STREAMED: Final = (
    "run",
    "view",
    "teach",
    "record",
    "replay",
)
GROUPS: Final[dict[str, tuple[str, ...]]] = {
    "start": ("demo", "run", "segment", "view", "teach"),
    "study": ("settings", "tune", "evaluate", "agree", "archive", "bench"),
    "operate": ("replay", "record", "adapters", "flink", "schema", "completion", "webcam"),
}
# Likely names of commands and options that have other names.
_MEANT: Final[dict[str, str]] = {
    "version": "mossar --version",
    "train": "mossar teach",
    "learn": "mossar teach",
    "listen": "mossar run",
    "start": "mossar run",
    "stream": "mossar run",
    "show": "mossar view",
    "dashboard": "mossar view",
    "camera": "mossar view webcam:",
    "plot": "mossar segment FILE --plot PICTURE.png",
    "csv": "mossar segment FILE --csv TABLE.csv",
    "count": "mossar segment FILE --repetitions",
    "play": "mossar view FILE",
    "send": "mossar replay FILE --to SINK",
    "formats": "mossar adapters",
    "list": "mossar adapters",
    "doctor": "mossar adapters",
}

_EPILOG = """examples:
  mossar demo                                  watch key frames of the built-in performer
  mossar run 39539                             segment what a VMC or Kinect program sends to this port
  mossar segment walk.bvh --plot walk.png      one picture of a recording
  mossar view demo:                            see the motion, and move the level live

mossar help COMMAND explains a command. mossar take.bvh segments a recording.
"""


class Command(Declares, Protocol):
    """A module that is a program's command."""

    def run(self, options: Any, console: Console) -> int:
        """Run the command and return the exit status; the options are a record of its `Options`."""


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


def run_command(
    prog: str, command: Command, arguments: Sequence[str], terminal: Console, *, assumed: bool = False
) -> int:
    """Parse the arguments of a command, run it, and return its exit status.

    Args:
        prog: The command as the user typed it.
        command: The command to run.
        arguments: After the command's name.
        terminal: Where words go.
        assumed: Whether the user typed no command, so that this one is reported.

    Raises:
        MossarError: If something is wrong with the arguments, or the files that they name.
    """
    from mossar_tools.options import parse
    from mossar_tools.places import check_command

    parser = parser_of(prog, command)
    try:
        options: Any = parse(parser, command.Options, arguments)
    except SystemExit:  # --help
        return DONE
    messages = options.messages
    level = messages.log_level or ("error" if messages.quiet else "debug" if messages.verbose else "info")
    terminal.set_up(level, as_json=messages.log_json, status=not messages.quiet)
    if assumed and not (prog.endswith("segment") and not Path(arguments[0]).exists()):
        LOGGER.info("this is %s %s", prog, " ".join(arguments)[:100])
    if prog.rpartition(" ")[2] in STREAMED:
        from mossar_tools.opening import spelled_out

        options = spelled_out(options)
    check_command(prog.rsplit(maxsplit=1)[-1], options)
    return command.run(options, terminal)


def command_called(name: str) -> Command:
    """Return the command of that name.

    Raises:
        UsageError: If there is none.
    """
    if name not in COMMANDS:
        raise UsageError(f"no command called {name[:40]!r}{_meant(name)}; there are {', '.join(COMMANDS)}")
    command: Command = importlib.import_module(f"mossar_tools.commands.{name}")
    return command


def _meant(name: str) -> str:
    """Return a question that names the likely command for an unknown one, or nothing."""
    word = name.lower().strip("-")
    return f" - did you mean {_MEANT[word]}?" if word in _MEANT else did_you_mean(word, COMMANDS)


def _run(arguments: list[str], terminal: Console) -> int:
    if arguments and arguments[0] == "help":
        arguments = [*arguments[1:2], "--help"]
    if len(arguments) == 2 and arguments[0] in {"-h", "--help"} and arguments[1] in COMMANDS:
        arguments = [arguments[1], "--help"]
    # Only --help or --version may stand before the command's name.
    if not arguments or (arguments[0].startswith("-") and arguments[0] != "-"):
        return _run_without_command(arguments or ["--help"], terminal)
    name = arguments[0]
    if name in COMMANDS:
        return run_command(f"mossar {name}", command_called(name), arguments[1:], terminal)
    from mossar_tools.opening import command_for

    if (meant := command_for(name)) is None:
        command_called(name)  # which raises that there is none
    name = meant or name
    return run_command(f"mossar {name}", command_called(name), arguments, terminal, assumed=True)


def _run_without_command(arguments: list[str], terminal: Console) -> int:
    parser = Parser(
        prog="mossar",
        description="Find, live, where one human motion ends and the next begins.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        usage="mossar COMMAND [options]",
    )
    parser.add_argument("-V", "--version", action="store_true", help="print the version and stop")
    for title, names in GROUPS.items():
        commands = parser.add_argument_group(title)
        for name in names:
            commands.add_argument(name, help=COMMANDS[name], nargs="?")
    wrong = arguments[0].lstrip("-").partition("=")[0]
    if wrong in COMMANDS:
        raise UsageError(f"{arguments[0]}: a command has no dashes: mossar {wrong} (see mossar --help)")
    try:
        found = parser.parse_args(arguments)
    except SystemExit:
        return DONE
    if found.version:
        terminal.line(f"mossar-stream {mossar_stream.__version__}")
        return DONE
    raise UsageError(
        f"which command? It comes first: mossar COMMAND {' '.join(arguments)[:60]} (see mossar --help)"
    )


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
