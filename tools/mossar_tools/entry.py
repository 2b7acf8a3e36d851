"""Entry: where the program begins, before anything that takes time is imported.

Python would answer Ctrl-C with a traceback while it imports. Nothing is open yet, so the process may end at once. The
script that `pip` writes works for a moment between the import of this module and the call of `main`, so the handlers
are there once the module is imported. Before that, only Python itself and that script run.
"""

import os
import signal
from types import FrameType


def main() -> int:
    """Run `mossar` and return its exit status; a signal during the imports ends the process without a word."""
    from mossar_tools.cli import main as program

    return program()


def _leave(number: int, _: FrameType | None) -> None:
    os._exit(128 + number)


for _number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(_number, _leave)
