"""Claims: a file that a run writes is written by no other run at the same time; each would spoil the other's.

The claim is a lock on a file beside it, because snapshots are replaced as a whole. The system releases the lock when the
process ends, even by `kill -9`; the file beside may stay then, and means nothing.
"""

import contextlib
from pathlib import Path

import filelock

from mossar_adapters.files.errors import FileError

_TRIES = 100  # a former owner may remove the file beside while it is being locked


class Claim:
    """Holds the right to write a file until `release`, or until the process ends.

    Pipes and devices are not claimed: writing to them replaces nothing. Neither are files in places where no lock can be
    had, such as a read-only folder.

    Args:
        path: The file; it need not exist.

    Raises:
        FileError: If another run, or this one, has it.
    """

    def __init__(self, path: Path | str) -> None:
        target = Path(path)
        self._lock: filelock.BaseFileLock | None = None
        with contextlib.suppress(OSError, ValueError, NotImplementedError):
            target = target.resolve()
            # The lock's library would make a folder that is missing, and the file could be written in it then.
            if target.parent.is_dir() and (target.is_file() or not target.exists()):
                self._lock = _locked(path, target.with_name(f".{target.name}.lock"))

    def release(self) -> None:
        """Let others write the file. May be called twice."""
        if self._lock is not None:
            with contextlib.suppress(OSError):  # Windows removes none that is open
                Path(self._lock.lock_file).unlink()
            self._lock.release()
            self._lock = None


def _locked(path: Path | str, beside: Path) -> filelock.BaseFileLock:
    """Return a lock on a file that is there."""
    lock = filelock.FileLock(beside, thread_local=False)  # sinks are closed by the thread that feeds them
    try:
        for _ in range(_TRIES):
            lock.acquire(timeout=0)
            if beside.exists():
                break
            lock.release()
    except filelock.Timeout:
        raise FileError(path, "another run is writing it; end that run, or name another file") from None
    return lock
