"""Places: folders and buckets, read and written alike."""

import contextlib
import posixpath
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory

import pyarrow as pa
from pyarrow import fs

from mossar_adapters.files import FORMATS
from mossar_stream import MossarError

EXTENSIONS = tuple(sorted({extension for form in FORMATS for extension in form.extensions}))
COMPANION = ".asf"  # the skeleton of recordings beside it


class Place:
    """A folder, or a part of a bucket.

    Args:
        url: A path, or a URL such as `s3://bucket/folder`.

    Raises:
        MossarError: If there is no such kind of place.
    """

    def __init__(self, url: str) -> None:
        self.url = url
        try:
            if "://" in url:
                self._files, root = fs.FileSystem.from_uri(url)
            else:
                self._files, root = fs.LocalFileSystem(), str(Path(url).absolute())
        except (pa.ArrowException, OSError, ValueError) as error:
            raise MossarError(f"{url}: {_line(error)}") from None
        self.root = root.rstrip("/")

    def paths(self, folder: str = "") -> list[str]:
        """Return the paths of all files in a folder and below, relative to this place; none if it is absent.

        Raises:
            MossarError: If the place cannot be read.
        """
        base = self._path(folder)
        try:
            found = self._files.get_file_info(fs.FileSelector(base, allow_not_found=True, recursive=True))
        except (pa.ArrowException, OSError) as error:
            raise MossarError(f"{self.url}: cannot be read: {_line(error)}") from None
        cut = len(self.root) + 1
        return sorted(entry.path[cut:] for entry in found if entry.is_file)

    def exists(self) -> bool:
        """Return whether there is a folder."""
        return bool(self._files.get_file_info(self.root).type == fs.FileType.Directory)

    @contextlib.contextmanager
    def local(self, path: str) -> Iterator[Path]:
        """Lend a file as a local one, with the skeletons that lie beside it.

        Raises:
            MossarError: If it cannot be read.
        """
        if isinstance(self._files, fs.LocalFileSystem) and "://" not in self.url:
            yield Path(self._path(path))
            return
        with TemporaryDirectory(prefix="mossar-") as folder:
            try:
                for name in [path, *self._companions(path)]:
                    self._fetch(name, Path(folder, PurePosixPath(name).name))
            except (pa.ArrowException, OSError) as error:
                raise MossarError(f"{path}: cannot be read: {_line(error)}") from None
            yield Path(folder, PurePosixPath(path).name)

    def read(self, path: str) -> pa.NativeFile:
        """Open a file for reading."""
        return self._files.open_input_file(self._path(path))

    @contextlib.contextmanager
    def write(self, path: str) -> Iterator[pa.NativeFile]:
        """Write a file that is there whole or not at all; readers pass over names that begin with a dot."""
        folder, name = posixpath.split(self._path(path))
        waiting = f"{folder}/.{name}.tmp"
        self._files.create_dir(folder)
        with self._files.open_output_stream(waiting) as stream:
            yield stream
        self._files.move(waiting, f"{folder}/{name}")

    def delete(self, path: str) -> None:
        """Delete a file."""
        self._files.delete_file(self._path(path))

    def _path(self, path: str) -> str:
        return f"{self.root}/{path}" if path else self.root

    def _companions(self, path: str) -> list[str]:
        if not path.lower().endswith(".amc"):
            return []
        folder = posixpath.dirname(path)
        return [
            name
            for name in self.paths(folder)
            if posixpath.dirname(name) == folder and name.lower().endswith(COMPANION)
        ]

    def _fetch(self, path: str, to: Path) -> None:
        with self.read(path) as source, to.open("wb") as target:
            while data := source.read(1 << 20):
                target.write(data)


def is_recording(path: str) -> bool:
    """Return whether a file is taken for a recording: by its extension; hidden ones are not."""
    return path.lower().endswith(EXTENSIONS) and not PurePosixPath(path).name.startswith(".")


def _line(error: Exception) -> str:
    return " ".join(str(error).split())[:300]
