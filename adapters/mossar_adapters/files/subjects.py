"""Marker names with the name of their subject in front, `anna:LFHD`."""

from collections.abc import Sequence
from pathlib import Path

import msgspec

from mossar_adapters.files.errors import FileError
from mossar_stream import performer_name


class Subject(msgspec.Struct, frozen=True):
    """The markers of one subject.

    Args:
        name: Of the performer; `p1` if the labels have none.
        labels: Without the subject's name.
        columns: Index of each marker among all of them.
    """

    name: str
    labels: tuple[str, ...]
    columns: tuple[int, ...]


def subjects_of(
    path: Path, labels: Sequence[str], wanted: str | None
) -> tuple[list[Subject], tuple[str, ...]]:
    """Return the subjects to read, all with the same labels, and notes about the others.

    Subjects with the labels of the one that is wanted (else of the one with most markers) are performers;
    others, such as props, are left out.

    Args:
        path: For messages.
        labels: All markers.
        wanted: Name of the wanted performer.

    Raises:
        FileError: If there is no marker.
    """
    groups: dict[str, list[int]] = {}
    for i, label in enumerate(labels):
        groups.setdefault(label.rpartition(":")[0], []).append(i)
    if not groups:
        raise FileError(path, "there are no markers in the file")
    subjects = [
        Subject(
            performer_name(prefix) if prefix else "p1",
            tuple(labels[i].rpartition(":")[2] for i in columns),
            tuple(columns),
        )
        for prefix, columns in groups.items()
    ]
    if len(subjects) == 1:
        only = subjects[0]
        return [Subject("p1" if wanted != only.name else only.name, only.labels, only.columns)], ()
    chosen = max(subjects, key=lambda s: (s.name == wanted, len(s.labels)))
    alike = [_in_order_of(s, chosen) for s in subjects if sorted(s.labels) == sorted(chosen.labels)]
    others = [f"{s.name} ({len(s.labels)})" for s in subjects if sorted(s.labels) != sorted(chosen.labels)]
    return alike, ((f"markers left out: {', '.join(others[:8])}",) if others else ())


def _in_order_of(subject: Subject, model: Subject) -> Subject:
    places = sorted(range(len(subject.labels)), key=lambda i: subject.labels[i])
    ranks = sorted(range(len(model.labels)), key=lambda i: model.labels[i])
    columns = [0] * len(places)
    for place, rank in zip(places, ranks, strict=True):
        columns[rank] = subject.columns[place]
    return Subject(subject.name, model.labels, tuple(columns))
