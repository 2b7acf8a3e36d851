"""`.msk` as a sink of frames: what `mossar record` writes."""

from mossar_adapters.address import Address
from mossar_adapters.files.msk import MskWriter
from mossar_adapters.source import Meta
from mossar_stream import Frames


class MskFrameSink:
    """Appends metas and frames to a recording; implements `FrameSink`.

    Args:
        address: Path of the file.
        force: Whether to replace a file that is there.
        position: Go on at this byte of a recording that is there.

    Raises:
        FileError: If there is a file and `force` is not given, or the path cannot be written.
    """

    def __init__(self, address: Address, *, force: bool = False, position: int | None = None) -> None:
        self.name = address.url
        self._writer = MskWriter(address.path, force=force, position=position)

    def announce(self, meta: Meta) -> None:
        """Write a meta."""
        self._writer.write(meta)

    def send_frames(self, frames: Frames) -> None:
        """Write frames."""
        self._writer.write(frames)

    def position(self) -> int:
        """Return the bytes in the file."""
        return self._writer.position()

    def sync(self) -> None:
        """Have everything written to the disk, before a snapshot counts on it."""
        self._writer.sync()

    def close(self) -> None:
        """Write what is left. May be called twice."""
        self._writer.close()
