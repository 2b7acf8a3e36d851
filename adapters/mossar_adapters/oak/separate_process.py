"""Asides: runs a function of ours in a process of its own, which can be given up.

For calls into libraries that may take for ever, or that abort the process that ends meanwhile.
"""

import importlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Final

_LOOK: Final = 0.1  # s between two looks at whether to give up
_FAREWELL: Final = 2.0  # s for a killed process to end; one that waits for a broken device may not
_ORPHAN: Final = 0.5  # s between two looks at whether the parent is still there


def run_separately(
    function: Callable[..., None], *arguments: str, enough: Callable[[], bool]
) -> "subprocess.CompletedProcess[str] | None":
    """Run a function in another process of this interpreter; return its status and its output, None if given up.

    Ctrl-C is left to this process. The other ends with it, however that happens; on Windows not if it is killed.

    Args:
        function: One of a module that can be imported; it may write to standard output and call `sys.exit`.
        arguments: For the function.
        enough: Asked ten times a second whether to give up.

    Raises:
        OSError: If no process can be started.

    Example, of a function that a module of ours has::

        run_separately(say, "hello", enough=lambda: False).stdout  # 'hello'
    """
    # -P: a file of the user's in the folder where we were started is not to be taken for a library.
    command = [sys.executable, "-P", "-m", __name__, function.__module__, function.__name__, *arguments]
    places = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "PYTHONIOENCODING": "utf-8"}
    process = subprocess.Popen(  # noqa: S603 - this interpreter, our own words
        command,
        env=places,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
    )
    try:
        while True:
            try:
                written, complaints = process.communicate(timeout=_LOOK)
            except subprocess.TimeoutExpired:
                if enough():
                    return None
            else:
                return subprocess.CompletedProcess(command, process.returncode, written, complaints)
    finally:
        if process.returncode is None:
            process.kill()
            with suppress(subprocess.TimeoutExpired):
                process.communicate(timeout=_FAREWELL)


def _main() -> None:
    """Run the function that the command line names, while the parent process lives."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform != "win32":  # where the number of a parent does not show whether it lives
        threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    module, name, *arguments = sys.argv[1:]
    getattr(importlib.import_module(module), name)(*arguments)


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_ORPHAN)
    os._exit(1)


if __name__ == "__main__":
    _main()
