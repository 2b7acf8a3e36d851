"""Recorder: the output of the button, frames into `.msk` files that are never overwritten."""

import threading
from pathlib import Path

from mossar_adapters.files.msk import MskWriter
from mossar_adapters.newest import Newest
from mossar_adapters.source import Meta
from mossar_stream import Frames, MossarError
from mossar_tools.console import LOGGER

_MOST = 256  # performers remembered


class Recorder:
    """Writes frames while it is switched on. Any thread may call any method."""

    def __init__(self) -> None:
        self.path: Path | None = None  # being written
        self.frames = 0  # written
        self._writer: MskWriter | None = None
        self._metas: Newest[str, Meta] = Newest(_MOST)
        self._lock = threading.Lock()

    def announce(self, meta: Meta) -> None:
        """Note a performer."""
        with self._lock:
            self._metas[meta.performer] = meta
            self._append(meta)

    def write(self, frames: Frames) -> None:
        """Write frames, if a recording is on; a full disk ends the recording, not the stream."""
        with self._lock:
            if self._append(frames):
                self.frames += len(frames)

    def start(self, folder: Path) -> Path:
        """Begin a recording in a new file and return its path.

        Raises:
            FileError: If it cannot be written.
        """
        with self._lock:
            if self._writer is not None and self.path is not None:
                return self.path
            path = unused(folder, "recording", ".msk")
            self._writer, self.path, self.frames = MskWriter(path), path, 0
            for meta in self._metas.values():
                self._writer.write(meta)
        return path

    def stop(self) -> None:
        """End the recording, if one is on."""
        with self._lock:
            if self._writer is not None and self._close():
                LOGGER.info("%s: %d frames recorded", self.path, self.frames)

    def _append(self, item: Meta | Frames) -> bool:
        """Write something and return whether it was written."""
        if self._writer is None:
            return False
        try:
            self._writer.write(item)
        except MossarError as error:
            LOGGER.error("the recording has ended: %s", error)
            self._close()
            return False
        return True

    def _close(self) -> bool:
        """Close the file and return whether all of it was written."""
        writer, self._writer = self._writer, None
        try:
            if writer is not None:
                writer.close()
        except MossarError as error:
            LOGGER.error("the end of the recording is missing: %s", error)
            return False
        return True

    @property
    def running(self) -> bool:
        """Whether a recording is on."""
        return self._writer is not None


def unused(folder: Path, stem: str, suffix: str) -> Path:
    """Return the first of `stem-1`, `stem-2`, ... that is no file yet; the page has no say in it."""
    number = 1
    while (path := folder / f"{stem}-{number}{suffix}").exists():
        number += 1
    return path
