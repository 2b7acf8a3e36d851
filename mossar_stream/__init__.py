"""Streaming Mossar: tells, live, where one human motion ends and the next begins.

The names below are loaded when they are first used, so that `import mossar_stream` does not wait for the compiler.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mossar_stream.angles import RangeOfMotion, joint_angles, ranges_of_motion
    from mossar_stream.engine.curve_state import CurveState
    from mossar_stream.errors import FrameError, MossarError, MovesError, SettingsError, SnapshotError
    from mossar_stream.events import (
        BODY,
        FOLLOW_STATUSES,
        KEY_FRAME_KINDS,
        KEY_FRAME_STATUSES,
        MOVE_STATUSES,
        REPETITION_STATUSES,
        SEGMENT_STATES,
        SEGMENT_STATUSES,
        STEP_STATUSES,
        ActivityEvent,
        Event,
        FollowEvent,
        FollowStatus,
        KeyFrameEvent,
        KeyFrameKind,
        KeyFrameStatus,
        MoveEvent,
        MoveStatus,
        PhaseEvent,
        RepetitionEvent,
        RepetitionStatus,
        SegmentEvent,
        SegmentState,
        SegmentStatus,
        Side,
        StatsEvent,
        StepEvent,
        StepStatus,
        StreamChange,
        StreamEvent,
        to_json,
    )
    from mossar_stream.following.alignment import FollowState
    from mossar_stream.frames import MAX_PERFORMER_NAME, Frames, constant_times, narrow, performer_name
    from mossar_stream.jit.listening import on_first_compile
    from mossar_stream.moves.example import Example
    from mossar_stream.moves.explaining import Explanation
    from mossar_stream.moves.joints import joint_places
    from mossar_stream.moves.moves import Moves
    from mossar_stream.moves.oddity import Oddity
    from mossar_stream.moves.rules import FACINGS, Facing, MoveRule
    from mossar_stream.performers import Performers
    from mossar_stream.precompiling import precompile
    from mossar_stream.recording import KeyFrame, Result, Segment, Segmentation, segment_recording
    from mossar_stream.segmenter import Segmenter
    from mossar_stream.settings import (
        LEVEL_NAMES,
        SETTING_CHOICES,
        Center,
        Features,
        KernelForm,
        LevelName,
        Location,
        RangePolicy,
        ResolvedSettings,
        Rests,
        Settings,
        SimilarityName,
        Smoothing,
        Up,
        VarianceFloor,
    )
    from mossar_stream.settings.limits import SETTING_LIMITS
    from mossar_stream.similarity.comparison import Comparison
    from mossar_stream.skeleton import MAX_JOINTS, MAX_NAME, Skeleton
    from mossar_stream.steps.gait import Gait, Step, gait_of, step_table

_NAMES = {
    "angles": ("RangeOfMotion", "joint_angles", "ranges_of_motion"),
    "engine.curve_state": ("CurveState",),
    "precompiling": ("precompile",),
    "errors": ("FrameError", "MossarError", "MovesError", "SettingsError", "SnapshotError"),
    "events": (
        "BODY",
        "FOLLOW_STATUSES",
        "KEY_FRAME_KINDS",
        "KEY_FRAME_STATUSES",
        "MOVE_STATUSES",
        "REPETITION_STATUSES",
        "SEGMENT_STATES",
        "SEGMENT_STATUSES",
        "ActivityEvent",
        "STEP_STATUSES",
        "Event",
        "FollowEvent",
        "FollowStatus",
        "KeyFrameEvent",
        "KeyFrameKind",
        "KeyFrameStatus",
        "MoveEvent",
        "MoveStatus",
        "PhaseEvent",
        "RepetitionEvent",
        "RepetitionStatus",
        "SegmentEvent",
        "SegmentState",
        "SegmentStatus",
        "Side",
        "StatsEvent",
        "StepEvent",
        "StepStatus",
        "StreamChange",
        "StreamEvent",
        "to_json",
    ),
    "following.alignment": ("FollowState",),
    "frames": ("MAX_PERFORMER_NAME", "Frames", "constant_times", "narrow", "performer_name"),
    "jit.listening": ("on_first_compile",),
    "moves.example": ("Example",),
    "moves.joints": ("joint_places",),
    "moves.moves": ("Moves",),
    "moves.explaining": ("Explanation",),
    "moves.oddity": ("Oddity",),
    "moves.rules": ("FACINGS", "Facing", "MoveRule"),
    "performers": ("Performers",),
    "recording": ("KeyFrame", "Result", "Segment", "Segmentation", "segment_recording"),
    "segmenter": ("Segmenter",),
    "settings": (
        "LEVEL_NAMES",
        "SETTING_CHOICES",
        "Center",
        "Features",
        "KernelForm",
        "LevelName",
        "Location",
        "RangePolicy",
        "ResolvedSettings",
        "Rests",
        "Settings",
        "SimilarityName",
        "Smoothing",
        "Up",
        "VarianceFloor",
    ),
    "settings.limits": ("SETTING_LIMITS",),
    "similarity.comparison": ("Comparison",),
    "skeleton": ("MAX_JOINTS", "MAX_NAME", "Skeleton"),
    "steps.gait": ("Gait", "Step", "gait_of", "step_table"),
}
_HOMES = {name: home for home, names in _NAMES.items() for name in names}
__all__ = [
    "BODY",
    "FACINGS",
    "FOLLOW_STATUSES",
    "KEY_FRAME_KINDS",
    "KEY_FRAME_STATUSES",
    "LEVEL_NAMES",
    "MAX_JOINTS",
    "MAX_NAME",
    "MAX_PERFORMER_NAME",
    "MOVE_STATUSES",
    "REPETITION_STATUSES",
    "SEGMENT_STATES",
    "SEGMENT_STATUSES",
    "SETTING_CHOICES",
    "SETTING_LIMITS",
    "STEP_STATUSES",
    "ActivityEvent",
    "Center",
    "Comparison",
    "CurveState",
    "Event",
    "Example",
    "Explanation",
    "Facing",
    "Features",
    "FollowEvent",
    "FollowState",
    "FollowStatus",
    "FrameError",
    "Frames",
    "Gait",
    "KernelForm",
    "KeyFrame",
    "KeyFrameEvent",
    "KeyFrameKind",
    "KeyFrameStatus",
    "LevelName",
    "Location",
    "MossarError",
    "MoveEvent",
    "MoveRule",
    "MoveStatus",
    "Moves",
    "MovesError",
    "Oddity",
    "Performers",
    "PhaseEvent",
    "RangeOfMotion",
    "RangePolicy",
    "RepetitionEvent",
    "RepetitionStatus",
    "ResolvedSettings",
    "Rests",
    "Result",
    "Segment",
    "SegmentEvent",
    "SegmentState",
    "SegmentStatus",
    "Segmentation",
    "Segmenter",
    "Settings",
    "SettingsError",
    "Side",
    "SimilarityName",
    "Skeleton",
    "Smoothing",
    "SnapshotError",
    "StatsEvent",
    "Step",
    "StepEvent",
    "StepStatus",
    "StreamChange",
    "StreamEvent",
    "Up",
    "VarianceFloor",
    "constant_times",
    "gait_of",
    "joint_angles",
    "joint_places",
    "narrow",
    "on_first_compile",
    "performer_name",
    "precompile",
    "ranges_of_motion",
    "segment_recording",
    "step_table",
    "to_json",
]
__version__ = "0.1.0"


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
