"""Console: messages and the status line on standard error, results on standard output.

All messages to the user go through the logger `mossar`, so that libraries need not print.
"""

import contextlib
import json
import logging
import os
import shutil
import sys
import textwrap
import threading
import time
import warnings
from collections.abc import Callable, Sequence
from typing import Final, TextIO

from mossar_tools.bars import bar

LOGGER: Final = logging.getLogger("mossar")
PROGRESS: Final = logging.getLogger("mossar.progress")  # records have a `share`, 0 to 1, or None
LEVELS: Final = ("debug", "info", "warning", "error")

_BAR = 24  # characters of a progress bar
_PATIENCE = 2.0  # s that work takes before a progress bar shows
_STATUS_PERIOD = 0.1  # s between two updates of the status line
_ASCII: Final = {
    "·": "-",
    "→": "->",
    "…": "...",
    "✓": "hit",
    "✗": "miss",
    "±": "+-",
    "°": " deg",
    "—": "-",
    "–": "-",  # noqa: RUF001
}


class Console:
    """Output of a program. Any thread may call any method.

    Args:
        out: Standard output.
        err: Standard error.
    """

    def __init__(self, out: TextIO, err: TextIO) -> None:
        self.out = out
        self.err = err
        self.unicode = prints_unicode(out)
        self._lock = threading.RLock()
        self._shown = 0  # characters of the status line now on the screen
        self._rows = 0  # lines of the picture now on the screen
        self._last_status = 0.0  # monotonic s
        self._status_on = is_terminal(err)

    def set_up(self, level: str, *, as_json: bool, status: bool) -> None:
        """Send the logger's messages to standard error.

        Args:
            level: One of `LEVELS`.
            as_json: One JSON object per message.
            status: Whether status lines may be shown, if standard error is a terminal.
        """
        self._status_on = status and not as_json and is_terminal(self.err)
        handler = _Handler(self)
        handler.setFormatter(_JsonLines() if as_json else _Plain())
        LOGGER.handlers[:] = [handler]
        LOGGER.setLevel(level.upper())
        LOGGER.propagate = False
        PROGRESS.handlers[:] = [_Progress(self)]
        PROGRESS.setLevel(logging.DEBUG if self._status_on else logging.CRITICAL)
        PROGRESS.propagate = False
        warnings.showwarning = lambda message, *_, **__: LOGGER.warning("%s", message)

    @property
    def live(self) -> bool:
        """Whether status lines are shown."""
        return self._status_on

    def colour(self, text: str, code: str) -> str:
        """Return `text` in the colour of an ANSI code if standard output shows colours."""
        return f"\x1b[{code}m{text}\x1b[0m" if self.coloured else text

    @property
    def coloured(self) -> bool:
        """Whether standard output shows colours."""
        return is_terminal(self.out) and "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"

    def line(self, text: str) -> None:
        """Write a line of results to standard output."""
        with self._lock:
            self.clear()
            print(self.plain(text), file=self.out, flush=True)

    def say(self, text: str) -> None:
        """Write a line to standard error."""
        with self._lock, contextlib.suppress(OSError, ValueError):
            self.clear()
            print(_printable(text, self.err), file=self.err, flush=True)

    def plain(self, text: str) -> str:
        """Return `text` as standard output can print it."""
        return text if self.unicode else _printable(text, self.out)

    def status(self, text: str, *, now: bool = False) -> None:
        """Show a status line, at most ten times a second; nothing where standard error is no terminal."""
        moment = time.monotonic()
        if not self._status_on or (not now and moment - self._last_status < _STATUS_PERIOD):
            return
        self._last_status = moment
        text = _printable(text, self.err)[: self.width() - 1]
        with self._lock, contextlib.suppress(OSError, ValueError):
            self._erase_picture()
            print("\r" + text.ljust(self._shown), end="", file=self.err, flush=True)
            self._shown = len(text)

    def picture(self, lines: Sequence[str]) -> None:
        """Show lines in place of those before, at most ten times a second; nothing where standard error is no terminal."""
        moment = time.monotonic()
        if not self._status_on or moment - self._last_status < _STATUS_PERIOD:
            return
        self._last_status = moment
        shown = [_printable(line, self.err)[: self.width() - 1] for line in lines]
        with self._lock, contextlib.suppress(OSError, ValueError):
            self.clear()
            print("\n".join(shown), end="", file=self.err, flush=True)
            self._rows = len(shown)

    def _erase_picture(self) -> None:
        if self._rows:
            up = f"\x1b[{self._rows - 1}A" if self._rows > 1 else ""
            print(f"\r{up}\x1b[J", end="", file=self.err, flush=True)
        self._rows = 0

    def progress(self, share: float | None, text: str) -> None:
        """Show progress: a bar, where the share (0 to 1) is known, and the present task."""
        shown = "" if share is None else f"{bar(share, _BAR, fine=prints_unicode(self.err))} {share:4.0%}  "
        self.status(shown + text)

    def clear(self) -> None:
        """Remove the status line or the picture, before something else is written."""
        with self._lock, contextlib.suppress(OSError, ValueError):
            self._erase_picture()
            if self._shown:
                print("\r" + " " * self._shown + "\r", end="", file=self.err, flush=True)
            self._shown = 0

    def width(self) -> int:
        """Return the columns of the terminal."""
        return shutil.get_terminal_size().columns

    def height(self) -> int:
        """Return the lines of the terminal."""
        return shutil.get_terminal_size().lines

    def room(self) -> int | None:
        """Return the columns that a line of results may have; None where nothing limits them, as in a pipe."""
        return self.width() if is_terminal(self.out) or "COLUMNS" in os.environ else None

    def fold(self, text: str, indent: str = "  ") -> list[str]:
        """Return a text as lines that fit the terminal, broken between words.

        Args:
            text: A line.
            indent: Put before the second line and those after it.
        """
        room = self.room()
        text = self.plain(text)
        if room is None or len(text) <= room:
            return [text]
        first = text[: len(text) - len(text.lstrip())]
        return textwrap.wrap(text.lstrip(), room, initial_indent=first, subsequent_indent=first + indent) or [
            text
        ]


def console() -> Console:
    """Return the console of this process."""
    return Console(sys.stdout, sys.stderr)


def progress_of(text: str) -> Callable[[float], None]:
    """Return a function that shows the share (0 to 1) of work that begins now; it shows nothing in the first 2 s.

    Args:
        text: The task.
    """
    begun = time.monotonic()

    def show(share: float) -> None:
        if time.monotonic() - begun > _PATIENCE:
            PROGRESS.info("%s", text, extra={"share": share})

    return show


def is_terminal(stream: TextIO) -> bool:
    """Return whether `stream` is a terminal."""
    try:
        return stream.isatty()
    except (AttributeError, ValueError):
        return False


def prints_unicode(stream: TextIO) -> bool:
    """Return whether `stream` can print the characters used here."""
    try:
        "▕█▏✓→·".encode(stream.encoding or "ascii")
    except (UnicodeError, LookupError):
        return False
    return True


def _printable(text: str, stream: TextIO) -> str:
    encoding = stream.encoding or "ascii"
    try:
        text.encode(encoding)
    except UnicodeError:
        for fine, simple in _ASCII.items():
            text = text.replace(fine, simple)
        text = text.encode(encoding, "replace").decode(encoding)
    return text


class _Handler(logging.Handler):
    """Writes messages where the status line was."""

    def __init__(self, console: Console) -> None:
        super().__init__()
        self._console = console

    def emit(self, record: logging.LogRecord) -> None:
        self._console.say(self.format(record))


class _Progress(logging.Handler):
    """Shows the progress of libraries."""

    def __init__(self, console: Console) -> None:
        super().__init__()
        self._console = console

    def emit(self, record: logging.LogRecord) -> None:
        self._console.progress(getattr(record, "share", None), record.getMessage())


class _Plain(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        word = f"{record.levelname.lower()}: " if record.levelno >= logging.ERROR else ""
        text = record.getMessage()  # may quote data from outside, which must not steer a terminal
        return f"mossar: {word}{''.join(c if c.isprintable() else ' ' for c in text)}"


class _JsonLines(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        fields = {
            "time": round(record.created, 3),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
        }
        return json.dumps(fields)
