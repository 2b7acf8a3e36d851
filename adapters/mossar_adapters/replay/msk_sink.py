"""`.msk` as a sink of frames, the output of `mossar record`."""

from mossar_adapters.address import Address
from mossar_adapters.files.msk import MskWriter


class MskFrameSink(MskWriter):
    """Appends metas and frames to a recording; implements `FrameSink`.

    Args:
        address: Path of the file.
        force: Whether to replace a file that is there.
        position: Go on at this byte of a recording that is there.

    Raises:
        FileError: If there is a file and `force` is not given, or the path cannot be written.
    """

    def __init__(self, address: Address, *, force: bool = False, position: int | None = None) -> None:
        super().__init__(address.path, force=force, position=position)
        self.name = address.url

    announce = send_frames = MskWriter.write
