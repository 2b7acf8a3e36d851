"""Where compiled kernels are kept: a folder on disk per state of the sources.

Numba's own cache notices a change of the file that holds a kernel, but not of the kernels it calls. Ours lies in
a folder named after the contents of all sources that kernels are compiled from (`sources.py`), so that no stale kernel
is ever loaded. It is made when the first kernel is about to be compiled or loaded, not when the package is imported.

Kernels are code: none is loaded from a folder, or a file in it, that another user could have written, and root is no
exception.
"""

import contextlib
import os
import shutil
import stat
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numba

from mossar_stream.errors import MossarError
from mossar_stream.jit.sources import PACKAGE, digest
from mossar_stream.jit.sturdy_cache import SturdyCache

LONGEST_UNUSED = 30 * 86400.0  # s
MOST_FOLDERS = 8  # some megabytes each
OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


class Cache(NamedTuple):
    """The folder in use."""

    folder: Path
    lasts: bool  # whether other processes will find it, too


# numba keeps a cache in every dispatcher, and opening it makes folders: so they wait here until there is a folder.
_waiting: list[Callable[[], None]] = []
_open: list[Cache] = []


def cached(dispatcher: Any) -> Any:
    """Let what numba compiles for an entry point be kept as soon as the cache is open; return the entry point."""

    def give_cache() -> None:
        # numba raises a RuntimeError for a function that stands in no file.
        with contextlib.suppress(RuntimeError), _numba_cache_in(_open[0].folder):
            dispatcher._cache = SturdyCache(dispatcher.py_func)  # noqa: SLF001 - what enable_caching does

    if _open:
        give_cache()
    else:
        _waiting.append(give_cache)
    return dispatcher


def open_cache() -> Cache:
    """Open the cache, before the first entry point is compiled or loaded: an earlier one would not be kept.

    Raises:
        MossarError: If nothing can be written anywhere.
    """
    if not _open:
        _open.append(make_folder(_usual_parents(), f"kernels-{digest()}"))
        while _waiting:
            _waiting.pop()()
    return _open[0]


def make_folder(parents: Iterable[Path], name: str) -> Cache:
    """Return a folder for compiled kernels, made if need be.

    Several environments may share a parent, each with a folder of its own: other versions of numba, or of this
    package. So folders of other names are removed only when they were not used for `LONGEST_UNUSED`, or when
    `MOST_FOLDERS` others were used later.

    Args:
        parents: Where it may be, the best first; the first that can be written to and is nobody else's is taken.
        name: Of the folder, beginning with "kernels-".

    Raises:
        MossarError: If nothing can be written anywhere.
    """
    for parent in parents:
        folder = parent / name
        try:
            parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            folder.mkdir(mode=0o700, exist_ok=True)
            if not _is_ours(folder):
                continue
            os.utime(folder, (time.time(), time.time()))
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            _remove_unused(parent, folder)
            return Cache(folder, lasts=True)
    try:
        return Cache(Path(tempfile.mkdtemp(prefix="mossar-stream-")), lasts=False)
    except OSError:
        raise MossarError(
            "there is no folder to write compiled kernels to; set XDG_CACHE_HOME or TMPDIR to one"
        ) from None


def _is_ours(folder: Path) -> bool:
    """Tell whether nobody but this user, and root, can have put anything into a folder of kernels, or in its place."""
    try:
        if not stat.S_ISDIR(folder.lstat().st_mode):
            return False
        if not hasattr(os, "getuid"):  # Windows: folders belong to whom they lie with
            return True
        own = os.getuid()
        return (
            folder.parent.stat().st_uid in (own, 0)
            and not folder.lstat().st_mode & OTHERS_WRITE
            and all(path.lstat().st_uid == own for path in (folder, *folder.rglob("*")))
        )
    except OSError:
        return False


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
    """Return this user's folder in one that all users write to; it need not be there yet.

    Raises:
        OSError: If it is another user's, who could put other kernels there at any time.
    """
    if not hasattr(os, "getuid"):  # Windows has a parent for each user
        return parent / "mossar-stream"
    folder = parent / f"mossar-stream-{os.getuid()}"
    with contextlib.suppress(FileNotFoundError):
        found = folder.lstat()
        if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or found.st_mode & OTHERS_WRITE:
            raise PermissionError(f"{folder} is not this user's alone")
    return folder


@contextlib.contextmanager
def _numba_cache_in(folder: Path) -> Iterator[None]:
    config: Any = numba.config
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        config.CACHE_DIR = before
