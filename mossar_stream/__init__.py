"""Streaming Mossar: tells, live, where one human motion ends and the next begins.

The names below are loaded when they are first used, so that `import mossar_stream` does not wait for the compiler.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mossar_stream.engine.warm_up import precompile
    from mossar_stream.errors import FrameError, MossarError, SettingsError, SnapshotError
    from mossar_stream.events import (
        Event,
        KeyFrameEvent,
        RepetitionEvent,
        SegmentEvent,
        StatsEvent,
        StreamEvent,
    )
    from mossar_stream.frames import Frames
    from mossar_stream.jit.listening import on_first_compile
    from mossar_stream.performers import Performers
    from mossar_stream.recording import segment_recording
    from mossar_stream.segmenter import Segmenter
    from mossar_stream.settings import Settings
    from mossar_stream.skeleton import Skeleton

_HOMES = {
    "Event": "events",
    "FrameError": "errors",
    "Frames": "frames",
    "KeyFrameEvent": "events",
    "MossarError": "errors",
    "Performers": "performers",
    "RepetitionEvent": "events",
    "SegmentEvent": "events",
    "Segmenter": "segmenter",
    "Settings": "settings",
    "SettingsError": "errors",
    "Skeleton": "skeleton",
    "SnapshotError": "errors",
    "StatsEvent": "events",
    "StreamEvent": "events",
    "on_first_compile": "jit.listening",
    "precompile": "engine.warm_up",
    "segment_recording": "recording",
}
__all__ = [
    "Event",
    "FrameError",
    "Frames",
    "KeyFrameEvent",
    "MossarError",
    "Performers",
    "RepetitionEvent",
    "SegmentEvent",
    "Segmenter",
    "Settings",
    "SettingsError",
    "Skeleton",
    "SnapshotError",
    "StatsEvent",
    "StreamEvent",
    "on_first_compile",
    "precompile",
    "segment_recording",
]
__version__ = "0.1.0"


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value
