"""Asides: runs a function of ours in a process of its own, which can be given up.

For calls into libraries that may take for ever, or that abort the process that ends meanwhile.
"""

import os
import subprocess
import sys
from collections.abc import Callable
from typing import Final

_LOOK: Final = 0.1  # s between two looks at whether to give up


def aside(
    function: Callable[..., None], *arguments: str, enough: Callable[[], bool]
) -> "subprocess.CompletedProcess[str] | None":
    """Run a function in another process of this interpreter; return its status and what it wrote, None if given up.

    Args:
        function: One of a module that can be imported; it may write to standard output and call `sys.exit`.
        arguments: For the function.
        enough: Asked ten times a second whether to give up.

    Raises:
        OSError: If no process can be started.

    Example:
        >>> from this_package import say  # doctest: +SKIP
        >>> aside(say, "hello", enough=lambda: False).stdout  # doctest: +SKIP
        'hello'
    """
    name, module = function.__name__, function.__module__
    # -P: a file of the user's in the folder where we were started is not to be taken for a library.
    command = [sys.executable, "-P", "-c", f"import sys; from {module} import {name}; {name}(*sys.argv[1:])"]
    places = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    process = subprocess.Popen(  # noqa: S603 - this interpreter, our own words
        [*command, *arguments], env=places, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
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
            process.communicate()
