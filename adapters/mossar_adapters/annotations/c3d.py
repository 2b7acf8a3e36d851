"""Tiers as events of a C3D file, and back.

Key frames become `Key Frame`, steps `Foot Strike` and `Foot Off` of the left and right side, as gait laboratories call
them. A stretch becomes two events, `NAME Start` and `NAME End`.
"""

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

from mossar_adapters.annotations.tiers import (
    EVENTS,
    KEY_FRAMES,
    MOVES,
    REPETITIONS,
    STEPS,
    AnnotationError,
    Mark,
    Tier,
)
from mossar_adapters.files.c3d import first_time
from mossar_adapters.files.c3d_events import C3dEvent, read_events, write_events
from mossar_adapters.files.errors import FileError

SUFFIX = ".c3d"
_KEY_FRAME, _REPETITION = "Key Frame", "Repetition"
_START, _END = " Start", " End"
_FEET = {"strike": ("Foot Strike", 1), "off": ("Foot Off", 2)}  # labels and icons of Vicon
_STRIKES = {"foot strike", "heel strike", "initial contact", "foot contact", "strike", "fs", "hs", "ic", "fc"}
_OFFS = {"foot off", "toe off", "heel off", "off", "fo", "to"}


def is_c3d(path: Path) -> bool:
    """Return whether a file is called as C3D files are."""
    return path.suffix.lower() == SUFFIX


def check_source(source: str, target: Path) -> Path:
    """Return the recording of which a copy with events can be written.

    Raises:
        AnnotationError: If it is no C3D file, or the target itself.
    """
    path = Path(source)
    if not is_c3d(path) or not path.is_file():
        raise AnnotationError(f"{target}: events go into a copy of a C3D file; {source} is none")
    if target.exists() and target.samefile(path):
        raise AnnotationError(f"{target}: this is the recording itself; name another file")
    return path


def write_c3d_events(source: str, target: Path, tiers: Sequence[Tier]) -> int:
    """Write a copy of a C3D file with the marks of tiers as events: key frames, steps, moves and repetitions.

    Args:
        source: The recording.
        target: The copy.
        tiers: Others are left out, because their boundaries are key frames.

    Returns:
        How many events were added.

    Raises:
        MossarError: If the recording is no C3D file, is the target itself, or the copy cannot be written.
    """
    path = check_source(source, target)
    origin = first_time(path)
    return write_events(path, target, [event for tier in tiers for event in _events(tier, origin)])


def _events(tier: Tier, origin: float) -> list[C3dEvent]:
    found = []
    for mark in tier.marks:
        start, end = origin + mark.start, origin + mark.end
        if tier.name == KEY_FRAMES:
            found.append(C3dEvent(_KEY_FRAME, start, description=mark.label))
        elif tier.name == STEPS:
            side, _, status = mark.label.partition(" ")
            label, icon = _FEET[status]
            found.append(C3dEvent(label, start, side.capitalize(), icon))
        elif tier.name.endswith((MOVES, REPETITIONS)):
            limb = tier.name.removesuffix(MOVES).removesuffix(REPETITIONS)
            name = mark.label if tier.name.endswith(MOVES) else f"{limb}{_REPETITION}".capitalize()
            context = next((side for side in ("Left", "Right") if limb.startswith(side.lower())), "General")
            text = "" if tier.name.endswith(MOVES) else mark.label
            found.append(C3dEvent(name + _START, start, context, description=text))
            found.append(C3dEvent(name + _END, end, context, description=text))
    return found


def read_c3d_events(path: Path) -> list[Tier]:
    """Return the events of a C3D file as tiers: steps, key frames, moves, repetitions, and `events` for all others.

    Raises:
        AnnotationError: If the file is damaged or has no events.
    """
    try:
        events = sorted(read_events(path), key=lambda event: event.time)
        origin = first_time(path)
    except FileError as error:
        raise AnnotationError(str(error)) from None
    if not events:
        raise AnnotationError(f"{path}: there are no events in it; the group EVENT is empty or missing")
    tiers: dict[str, list[Mark]] = defaultdict(list)
    begun: dict[tuple[str, str], float] = {}
    for event in events:
        time = max(0.0, event.time - origin)
        name = event.label.removesuffix(_START).removesuffix(_END)
        if event.label.endswith(_START):
            begun[name, event.context] = time
        elif event.label.endswith(_END) and (name, event.context) in begun:
            label = event.description or name
            tiers[_tier_of(name)].append(Mark(begun.pop((name, event.context)), time, label))
        else:
            tier, label = _moment(event)
            tiers[tier].append(Mark(time, time, label))
    for (name, _), time in begun.items():
        tiers[EVENTS].append(Mark(time, time, name + _START))
    return [
        Tier(name, tuple(sorted(marks)), moments=all(mark.start == mark.end for mark in marks))
        for name, marks in tiers.items()
    ]


def _tier_of(name: str) -> str:
    """Return the tier of a stretch."""
    if name.lower().endswith(_REPETITION.lower()):
        return name[: -len(_REPETITION)].lower() + REPETITIONS
    return MOVES


def _moment(event: C3dEvent) -> tuple[str, str]:
    """Return the tier and the label of an event that is a moment."""
    plain, side = event.label.lower().replace("_", " ").strip(), event.context.lower()
    if side in {"left", "right"} and plain in _STRIKES | _OFFS:
        return STEPS, f"{side} {'strike' if plain in _STRIKES else 'off'}"
    if event.label == _KEY_FRAME:
        return KEY_FRAMES, event.description
    return EVENTS, event.label if side == "general" else f"{event.context} {event.label}"
