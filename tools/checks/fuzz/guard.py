"""Guard: limits of time and memory, so that a hang or a blow-up is found instead of suffered."""

import resource
import signal
import warnings
from pathlib import Path
from types import FrameType

SECONDS = 10.0  # for one input
MEMORY = 1024 << 20  # bytes beyond the program's memory at the beginning


class Hang(BaseException):
    """An input took too long. No `Exception`: nothing is to catch it but the fuzzer."""


class TimeLimit:
    """Raises `Hang` in the main thread if the block takes longer than `SECONDS`."""

    def __enter__(self) -> None:
        signal.setitimer(signal.ITIMER_REAL, SECONDS)

    def __exit__(self, *_: object) -> None:
        signal.setitimer(signal.ITIMER_REAL, 0)


time_limit = TimeLimit()


def set_limits() -> None:
    """Make hangs, blow-ups and warnings errors. For the whole process."""
    signal.signal(signal.SIGALRM, _hang)
    limit = _status("VmSize") + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))
    warnings.simplefilter("error")
    warnings.filterwarnings("ignore", message="performer .* m tall")  # of random numbers


def memory() -> int:
    """Return the memory in use, bytes."""
    return _status("VmRSS")


def _hang(number: int, frame: FrameType | None) -> None:
    del number, frame
    raise Hang(f"longer than {SECONDS:.0f} s")


def _status(name: str) -> int:
    """Return a figure of /proc/self/status, bytes; 0 where there is none."""
    try:
        text = Path("/proc/self/status").read_text(encoding="ascii")
    except OSError:
        return 0
    return next((int(line.split()[1]) << 10 for line in text.splitlines() if line.startswith(name)), 0)
