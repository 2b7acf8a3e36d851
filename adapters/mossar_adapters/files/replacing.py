"""Replacing: no output replaces an input, and one that replaces a file does so as a whole, at the end.

`check_places` is the rule for inputs and outputs; every command asks it before anything is opened. `Draft` is the file
beside: a full disk, a crash or an error leaves the old file as it was.
"""

import contextlib
import glob
import os
import secrets
import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Self

from mossar_adapters.address import parse_url
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.registry import ESTIMATE_SUFFIX
from mossar_stream import SettingsError

_NEVER_READ = (".png", ".svg", ".pdf")  # pictures may lie in a folder of recordings and labels

_Key = tuple[int, int] | str  # device and number of a file; its path, of one that is not there


def check_places(read: Iterable[str], written: Iterable[str]) -> None:
    """Refuse to write an input, or one place twice.

    Links, hard ones too, are followed. The skeletons beside an `.amc`, the poses beside a video, files that options of
    a URL name, and the files of a folder that is read, are read, too.

    Args:
        read: Paths, patterns and URLs.
        written: Paths and URLs. `-` counts as a place.

    Raises:
        FileError: If a place is written that is read, or is written twice.
    """
    written = list(written)
    inputs = [Path(name) for url in read for name in _files_of(url)]
    inputs += [Path(name) for url in written for name in _named_by_options(url)]
    folders = {_key(path) for path in inputs if path.is_dir()}
    taken = {_key(path) for path in inputs} | {url for url in read if _path_of(url) is None and url != "-"}
    for url in written:
        path = _path_of(url)
        key = url if path is None else _key(Path(path))
        if key is None:
            continue
        if key in taken or (path is not None and _lies_in(Path(path), folders)):
            raise FileError(
                url, "it is an input here, or another output; nothing can be both, write another file"
            )
        taken.add(key)


def _path_of(url: str) -> str | None:
    """Return the path that a URL stands for, None if it is no file."""
    try:
        address = parse_url(url)
    except SettingsError:  # which is reported where the URL is opened
        return None
    if address.scheme == "file":
        return address.path or None
    return address.path if address.scheme == "midi" and address.path else None


def _files_of(url: str) -> Iterator[str]:
    """Yield the paths of an input, and of the files that are read with it."""
    yield from _named_by_options(url)
    path = _path_of(url)
    if path is None:
        return
    found = glob.glob(path) if glob.has_magic(path) and not Path(path).exists() else [path]  # noqa: PTH207 - of any folder
    for name in found:
        yield name
        yield from map(str, _companions(Path(name)))


def _named_by_options(url: str) -> Iterator[str]:
    """Yield the files that the options of a URL name, as `skeleton` and `key` do."""
    with contextlib.suppress(SettingsError):
        for value in parse_url(url).options.values():
            if os.path.isfile(value):  # noqa: PTH113 - any text, also one that is no path
                yield value


def _companions(path: Path) -> list[Path]:
    """Return the files that may be read with a recording."""
    suffix = path.suffix.lower()
    if suffix == ".amc" and path.parent.is_dir():
        return [beside for beside in path.parent.iterdir() if beside.suffix.lower() == ".asf"]
    kept = Path(f"{path}{ESTIMATE_SUFFIX}")  # poses of a video
    return [kept] if kept.exists() else []


def _key(path: Path) -> _Key | None:
    """Return the identity of a file; None for pipes and devices, which are never replaced."""
    try:
        found = path.stat()
        if not path.is_file() and not path.is_dir():
            return None
        if found.st_ino:
            return found.st_dev, found.st_ino
    except (OSError, ValueError):
        pass
    return os.path.normcase(os.path.realpath(path))


def _lies_in(path: Path, folders: set[_Key | None]) -> bool:
    """Return whether a file that is there lies in a folder that is read, or below."""
    if not folders or not path.is_file() or path.suffix.lower() in _NEVER_READ:
        return False
    return any(_key(parent) in folders for parent in Path(os.path.realpath(path)).parents)


class Draft:
    """A file beside another one, in whose place it is put when it is whole.

    Pipes and devices are written themselves. So are files in a folder that takes no new ones.

    Args:
        target: The file that is to be written; a link stands for its target.

    Raises:
        OSError: If nothing can be written there.

    Example:
        >>> from mossar_adapters.files.replacing import Draft
        >>> draft = Draft("/dev/null")
        >>> draft.path.name, draft.put()
        ('null', None)
    """

    def __init__(self, target: Path | str) -> None:
        self._target = Path(os.path.realpath(target))
        self.path = self._target
        there = self._target.exists()
        self.replaces = there and self._target.is_file()
        if (there and not self._target.is_file()) or (
            self.replaces and not os.access(self._target.parent, os.W_OK)
        ):
            return
        # The suffix stays, because libraries choose the format by it.
        beside = f".{self._target.stem[:80]}.{secrets.token_hex(4)}{self._target.suffix}"
        self.path = self._target.with_name(beside)
        self.path.touch(exist_ok=False)
        if there:
            shutil.copymode(self._target, self.path)

    def put(self) -> None:
        """Put the file in its place.

        Raises:
            OSError: If that is impossible; the old file is as it was.
        """
        if self.path == self._target:
            return
        try:
            with self.path.open("rb+") as file:
                os.fsync(file.fileno())
            self.path.replace(self._target)
        except OSError:
            self.drop()
            raise

    def drop(self) -> None:
        """Leave the old file as it was."""
        if self.path != self._target:
            self.path.unlink(missing_ok=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        if kind is None:
            self.put()
        else:
            self.drop()
