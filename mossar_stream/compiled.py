"""How kernels are compiled: numba, without the interpreter lock, cached on disk per state of the sources.

Numba's own cache notices a change of the file that holds a kernel, but not of the kernels it calls. Ours lies in
a folder named after all sources of this package, so that no stale kernel is ever loaded.
"""

import contextlib
import hashlib
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import event

F = TypeVar("F", bound=Callable[..., object])


def _digest() -> str:
    files = sorted(Path(__file__).parent.glob("*.py"))
    facts = [f"{file.name}:{(stat := file.stat()).st_mtime_ns}:{stat.st_size}" for file in files]
    return hashlib.sha256("\n".join([numba.__version__, *facts]).encode()).hexdigest()[:16]


def _cache_folder() -> Path:
    """Return the folder for compiled kernels, made if need be, and remove those of older sources."""
    name = f"kernels-{_digest()}"
    own = Path(__file__).parent / "__pycache__"
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "mossar-stream"
    for parent in (own, home, Path(tempfile.gettempdir()) / "mossar-stream"):
        folder = parent / name
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            for stale in parent.glob("kernels-*"):
                if stale != folder:
                    shutil.rmtree(stale, ignore_errors=True)
            return folder
    return Path(tempfile.mkdtemp(prefix="mossar-stream-"))


CACHE_FOLDER = _cache_folder()


@contextlib.contextmanager
def _numba_cache_in(folder: Path) -> Iterator[None]:
    config: Any = numba.config
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        config.CACHE_DIR = before


# No fastmath: it gains nothing here, and it permits dropping NaN checks and reordering sums, which breaks the
# frame-for-frame equality with the reference.
#
# No reference counts either: kernels work on views of arrays that their caller holds, and counting who looks at them,
# atomically, was a quarter of the time. The few that make arrays of their own are `allocating`.
_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True, "_nrt": True}
_BARE: dict[str, Any] = {**_OPTIONS, "_nrt": False}
_INNER: dict[str, Any] = {"no_cpython_wrapper": True}


def compiled(function: F) -> F:
    """Compile a function that only other kernels call (decorator).

    It has no wrapper for calls from Python, which saves a third of the time to compile everything; calling it
    from Python would crash.
    """
    return cast("F", numba.njit(**_BARE, **_INNER)(function))


def allocating(function: F) -> F:
    """Compile a function that only other kernels call and that makes arrays, for itself or the `allocating` (decorator).

    A kernel without reference counts would never free an array that it got from here.
    """
    return cast("F", numba.njit(**_OPTIONS, **_INNER)(function))


def spliced(function: F) -> F:
    """Compile a function as a part of the one kernel that calls it (decorator).

    A kernel's callees are optimised again in each of their callers; one that is spliced in is not.
    """
    return cast("F", numba.njit(inline="always", **_BARE, **_INNER)(function))


def entry_point(function: F) -> F:
    """Compile a kernel that Python calls, on its first call, and cache it on disk (decorator).

    It may make arrays.
    """
    with _numba_cache_in(CACHE_FOLDER):
        return cast("F", numba.njit(cache=True, **_OPTIONS)(function))


def bare_entry_point(function: F) -> F:
    """Compile like an `entry_point`, but without reference counts: it makes no arrays (decorator)."""
    with _numba_cache_in(CACHE_FOLDER):
        return cast("F", numba.njit(cache=True, **_BARE)(function))


class _Teller(event.Listener):
    """Calls once, when compiling begins; what comes from the disk is loaded without it."""

    def __init__(self, say: Callable[[], None]) -> None:
        self._say: Callable[[], None] | None = say

    def on_start(self, _: object) -> None:
        say, self._say = self._say, None
        if say is not None:
            say()

    def on_end(self, _: object) -> None:
        pass


@contextlib.contextmanager
def telling(say: Callable[[], None]) -> Iterator[None]:
    """Call `say` once if a kernel is compiled while the block runs, which takes seconds, and as it begins."""
    with event.install_listener("numba:compile", _Teller(say)):
        yield
