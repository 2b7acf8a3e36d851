"""How kernels are compiled: numba, without the interpreter lock, cached on disk per state of the sources.

Numba's own cache notices a change of the file that holds a kernel, but not of the kernels it calls. Ours lies in
a folder named after all sources of this package, so that no stale kernel is ever loaded.
"""

import contextlib
import hashlib
import os
import shutil
import stat
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import event
from numba.core.caching import FunctionCache
from numba.extending import intrinsic, overload

from mossar_stream.errors import MossarError
from mossar_stream.jit.inner import InnerCompiler

PACKAGE = Path(__file__).parents[1]
F = TypeVar("F", bound=Callable[..., object])


LONGEST_UNUSED = 30 * 86400.0  # s
MOST_FOLDERS = 8  # some megabytes each


def _digest() -> str:
    files = sorted(PACKAGE.rglob("*.py"))
    facts = [
        f"{file.relative_to(PACKAGE).as_posix()}:{(stat := file.stat()).st_mtime_ns}:{stat.st_size}"
        for file in files
    ]
    return hashlib.sha256("\n".join([numba.__version__, *facts]).encode()).hexdigest()[:16]


def cache_folder(parents: Iterable[Path], name: str) -> tuple[Path, bool]:
    """Return a folder for compiled kernels, made if need be, and whether other processes will find it, too.

    Several environments may share a parent, each with a folder of its own: other versions of numba, or of this
    package. So folders of other names are removed only when they were not used for `LONGEST_UNUSED`, or when
    `MOST_FOLDERS` others were used later.

    Args:
        parents: Where it may be, the best first; the first that can be written to.
        name: Of the folder, beginning with "kernels-".

    Raises:
        MossarError: If nothing can be written anywhere.
    """
    for parent in parents:
        folder = parent / name
        try:
            folder.mkdir(parents=True, exist_ok=True)
            # Only the owner may set a time. Kernels are code: none is loaded from somebody else's folder.
            os.utime(folder, (time.time(), time.time()))
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            _remove_unused(parent, folder)
            return folder, True
    try:
        return Path(tempfile.mkdtemp(prefix="mossar-stream-")), False
    except OSError:
        raise MossarError(
            "there is no folder to write compiled kernels to; set XDG_CACHE_HOME or TMPDIR to one"
        ) from None


def _remove_unused(parent: Path, own: Path) -> None:
    """Remove other folders of kernels that nobody seems to use any more."""
    used: list[tuple[float, Path]] = []
    for folder in set(parent.glob("kernels-*")) - {own}:
        with contextlib.suppress(OSError):  # another process may be removing it
            used.append((folder.stat().st_mtime, folder))
    for place, (when, folder) in enumerate(sorted(used, reverse=True)):
        if place >= MOST_FOLDERS or when < time.time() - LONGEST_UNUSED:
            shutil.rmtree(folder, ignore_errors=True)


def _usual_parents() -> Iterator[Path]:
    """Yield where kernels may be, the best first; a place that a system lacks is left out."""
    yield PACKAGE / "__pycache__"
    with contextlib.suppress(RuntimeError):  # no HOME, and a user whom the system does not know
        yield Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "mossar-stream"
    with contextlib.suppress(OSError):
        yield own_temporary(Path(tempfile.gettempdir()))


def own_temporary(parent: Path) -> Path:
    """Return this user's folder in one that all users write to, made if need be.

    Raises:
        OSError: If it cannot be made, or is another user's, who could put other kernels there at any time.
    """
    if not hasattr(os, "getuid"):  # Windows has a parent for each user
        return parent / "mossar-stream"
    folder = parent / f"mossar-stream-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid():
        raise PermissionError(f"{folder} is not this user's")
    return folder


CACHE_FOLDER, CACHE_LASTS = cache_folder(_usual_parents(), f"kernels-{_digest()}")


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
_OPTIONS: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",
    "no_cfunc_wrapper": True,
    "forceinline": False,  # said, because callees inherit what is not
}
_NO_COUNTING: dict[str, Any] = {"_nrt": False}  # callees inherit it
_INNER: dict[str, Any] = {"no_cpython_wrapper": True, "pipeline_class": InnerCompiler}


def compiled(function: F) -> F:
    """Compile a function that only other kernels call (decorator).

    It has neither a wrapper for calls from Python nor machine code, which saves half the time to compile
    everything; calling it from Python would crash.
    """
    return cast("F", numba.njit(**_OPTIONS, **_INNER)(function))


def inlined(function: F) -> F:
    """Compile a kernel on its own, and let LLVM copy it into those that call it (decorator).

    For what every frame goes through: an array is handed over as seven words on the stack, so that a call costs as
    much as a pass over the joints. A long one with several callers is better left to be called.
    """
    return cast("F", numba.njit(**{**_OPTIONS, **_INNER, "forceinline": True})(function))


def spliced(function: F) -> F:
    """Let numba copy a function into the kernel that calls it before anything is compiled (decorator).

    For parts of one large kernel, and for a line that is no more than a name: a kernel's callees are optimised again in
    each of their callers; one that is spliced in is not.
    """
    return cast("F", numba.njit(inline="always", **_OPTIONS, **_INNER)(function))


def generated(function: Callable[..., Any]) -> Callable[..., Any]:
    """Let a function write the code of calls to it (decorator); only kernels can call the result.

    The function takes numba's context and the types of the arguments, and returns a signature and what generates code.
    """
    return cast("Callable[..., Any]", intrinsic(function))


def chosen_by_type(function: Callable[..., object]) -> Callable[[F], F]:
    """Let a function's result, given the types of the arguments, be the kernel for calls of `function` (decorator)."""
    options: Any = {**_OPTIONS, **_INNER}
    return cast("Callable[[F], F]", overload(function, jit_options=options))


def entry_point(function: F) -> F:
    """Compile a kernel that Python calls, on its first call, and cache it on disk (decorator)."""
    return _cached(function, _OPTIONS)


def frame_entry_point(function: F) -> F:
    """Do the same for a kernel that makes no arrays, nor do those that it calls (decorator).

    Then nobody need count references to arrays, which costs frames a fifth of their time. Kernels that stand
    apart may make arrays.
    """
    return _cached(function, {**_OPTIONS, **_NO_COUNTING})


def _cached(function: F, options: dict[str, Any]) -> F:
    kernel = numba.njit(**options)(function)
    with _numba_cache_in(CACHE_FOLDER):
        kernel._cache = SturdyCache(function)  # noqa: SLF001 - what njit(cache=True) does, with numba's class
    return cast("F", kernel)


class SturdyCache(FunctionCache):
    """Numba's cache on disk, without which everything works, too, but for the time it takes to compile.

    A power cut leaves files empty or cut off, and a disk may be full; numba would let neither pass.
    """

    def load_overload(self, sig: object, target_context: object) -> object:
        """Return a kernel for a signature, None if there is none that can be read."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # noqa: BLE001 - damaged pickles raise anything
            with contextlib.suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: object, data: object) -> None:
        """Keep a kernel if there is room for it."""
        with contextlib.suppress(OSError):
            super().save_overload(sig, data)


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
