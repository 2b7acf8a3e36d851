"""Events of C3D files: the group EVENT, read, and written into a copy of the file.

Times of events count from frame 1 of the recording that the file was taken from, as its frame numbers do. Lists hold at most
255 elements; further ones are in LABELS2, TIMES2 and so on.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from mossar_adapters.files.c3d_copy import MOST, C3dCopy, Parameter, numbers, texts, words
from mossar_adapters.files.c3d_parameters import Value, read_parameters
from mossar_adapters.files.errors import FileError

GROUP = "EVENT"
MOST_EVENTS = 10_000
_TEXTS = ("CONTEXTS", "LABELS", "DESCRIPTIONS", "SUBJECTS")
_LISTS = (*_TEXTS, "TIMES", "ICON_IDS", "GENERIC_FLAGS")
_SAME = 1e-4  # s; events of the same name that are nearer are one


class C3dEvent(msgspec.Struct, frozen=True):
    """An event of a C3D file.

    Args:
        label: The kind of event, as `Foot Strike`.
        time: s from frame 1 on.
        context: `Left`, `Right` or `General`.
        icon: Number of the picture that programs show; 1 is a foot strike, 2 a foot off.
        description: For people.
        subject: Name of the performer.
        minutes: Whole minutes of `time` as the file has them.
        flag: As the file has it.
    """

    label: str
    time: float
    context: str = "General"
    icon: int = 0
    description: str = ""
    subject: str = ""
    minutes: float = 0.0
    flag: int = 0


def read_events(path: Path) -> list[C3dEvent]:
    """Return the events of a file, in its order.

    Raises:
        FileError: If it is damaged, or an event lacks its time.
    """
    try:
        _, _, parameters = read_parameters(path)
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror or error}") from None
    return _events(path, parameters)


def write_events(source: Path, target: Path, events: Sequence[C3dEvent]) -> int:
    """Write a copy of a file with more events; those that it has stay, and all else is copied byte by byte.

    Args:
        source: The recording.
        target: The copy.
        events: Those that the source has already are left out. Events without a subject get the first of the file.

    Returns:
        How many events were added.

    Raises:
        FileError: If the source is damaged, or there are too many events.
        OutputError: If the copy cannot be written.
    """
    _, machine, parameters = read_parameters(source)
    there = _events(source, parameters)
    subjects = parameters.get("SUBJECTS:NAMES")
    subject = subjects[0] if isinstance(subjects, list) and subjects else ""
    new = [event for event in events if not any(_is_same(event, other) for other in there)]
    named = [event if event.subject else msgspec.structs.replace(event, subject=subject) for event in new]
    written = [*there, *sorted(named, key=lambda event: event.time)]
    if len(written) > MOST_EVENTS:
        raise FileError(source, f"{len(written)} events are more than the {MOST_EVENTS} that are written")
    copy = C3dCopy(source)
    old = [f"{name}{k}" for name in _LISTS for k in range(2, MOST_EVENTS // MOST + 2)]
    copy.remove(GROUP, old)
    copy.replace(GROUP, [words("USED", [len(written)], machine, single=True), *_lists(written, machine)])
    copy.write(target)
    return len(new)


def _lists(events: Sequence[C3dEvent], machine: int) -> Iterator[Parameter]:
    for start in range(0, max(1, len(events)), MOST):
        own = events[start : start + MOST]
        more = f"{start // MOST + 1}" if start else ""
        yield texts(f"CONTEXTS{more}", [event.context for event in own])
        yield words(f"ICON_IDS{more}", [event.icon for event in own], machine)
        yield texts(f"LABELS{more}", [event.label for event in own])
        yield texts(f"DESCRIPTIONS{more}", [event.description for event in own])
        yield texts(f"SUBJECTS{more}", [event.subject for event in own])
        pairs = [(event.minutes, event.time - 60.0 * event.minutes) for event in own]
        yield numbers(f"TIMES{more}", pairs, machine)
        yield Parameter(f"GENERIC_FLAGS{more}", 1, (len(own),), bytes(event.flag & 255 for event in own))


def _events(path: Path, parameters: Mapping[str, Value]) -> list[C3dEvent]:
    used = parameters.get(f"{GROUP}:USED")
    count = int(used[0]) if isinstance(used, np.ndarray) and len(used) and np.isfinite(used[0]) else 0
    count += 65536 if count < 0 else 0
    if count > MOST_EVENTS:
        raise FileError(path, f"{count} events are more than the {MOST_EVENTS} that are read")
    written = {name: [str(value) for value in _all(parameters, name)] for name in _TEXTS}
    times = np.asarray(_all(parameters, "TIMES"), np.float64)
    there = min(len(times) // 2, len(written["LABELS"]))
    if there < count:
        raise FileError(path, f"there should be {count} events, but {there} of them have a label and a time")
    if not np.isfinite(times[: 2 * count]).all():
        raise FileError(path, "an event has a time that is no number")
    texts_ = {name: [*written[name], *[""] * count] for name in _TEXTS}
    icons, flags = ([*_all(parameters, name), *[0] * count] for name in ("ICON_IDS", "GENERIC_FLAGS"))
    return [
        C3dEvent(
            texts_["LABELS"][i],
            float(60.0 * times[2 * i] + times[2 * i + 1]),
            texts_["CONTEXTS"][i] or "General",
            int(icons[i]),
            texts_["DESCRIPTIONS"][i],
            texts_["SUBJECTS"][i],
            float(times[2 * i]),
            int(flags[i]),
        )
        for i in range(count)
    ]


def _all(parameters: Mapping[str, Value], name: str) -> list[Any]:
    """Return a list with its continuations, which have the same name and a number."""
    found: list[Any] = list(parameters.get(f"{GROUP}:{name}", ()))
    number = 2
    while (more := parameters.get(f"{GROUP}:{name}{number}")) is not None:
        found += list(more)
        number += 1
    return found


def _is_same(one: C3dEvent, other: C3dEvent) -> bool:
    return (one.label, one.context) == (other.label, other.context) and abs(one.time - other.time) < _SAME
