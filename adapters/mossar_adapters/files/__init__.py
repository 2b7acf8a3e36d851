"""Readers of recordings, and the writer of our own format."""

from importlib import import_module
from typing import TYPE_CHECKING

from mossar_adapters.files.errors import FileError
from mossar_adapters.files.kinematics import JointMotion, MotionChunk
from mossar_adapters.files.msk import MskWriter
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.registry import FORMATS, Format, open_motion, open_recording

if TYPE_CHECKING:
    from mossar_adapters.files.loaded import LoadedRecording, load, read

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


def __getattr__(name: str) -> object:
    # What can segment is loaded when it is first used: opening a recording need not wait for the compiler.
    if name not in {"LoadedRecording", "load", "read"}:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module("mossar_adapters.files.loaded"), name)
