"""Readers of recordings, and the writer of our own format."""

from mossar_adapters.files.errors import FileError
from mossar_adapters.files.kinematics import JointMotion, MotionChunk
from mossar_adapters.files.loaded import LoadedRecording, load, read
from mossar_adapters.files.msk import MskWriter
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.registry import FORMATS, Format, open_motion, open_recording

__all__ = [
    "FORMATS",
    "FileError",
    "Format",
    "JointMotion",
    "LoadedRecording",
    "MotionChunk",
    "MskWriter",
    "ReadOptions",
    "load",
    "open_motion",
    "open_recording",
    "read",
]


def __dir__() -> list[str]:
    return __all__
