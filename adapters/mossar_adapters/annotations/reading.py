"""Reading annotations back: what people corrected by hand, as tiers."""

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec

from mossar_adapters.annotations.tiers import AnnotationError, Mark, Tier
from mossar_adapters.annotations.writing import EXTRA
from mossar_adapters.extras import needed

MAX_BYTES = 64 << 20


def chosen_tier(path: Path, wanted: str | None, usual: Sequence[str]) -> Tier:
    """Return a tier of an annotation file.

    Args:
        path: See `read_annotations`.
        wanted: Its name; None for the first of the usual ones that is there, or else the only one there is.
        usual: Names.

    Raises:
        MossarError: If the file cannot be read, or it is not clear which tier is meant.
    """
    tiers = {tier.name: tier for tier in read_annotations(path)}
    for name in usual if wanted is None else (wanted,):
        if name in tiers:
            return tiers[name]
    if wanted is None and len(tiers) == 1:
        return next(iter(tiers.values()))
    there = ", ".join(tiers) or "none"
    names = " or ".join(usual if wanted is None else (wanted,))
    raise AnnotationError(f"{path}: there is no tier called {names}; there are: {there}")


def read_annotations(path: Path) -> list[Tier]:
    """Return the tiers of a file.

    Args:
        path: `.eaf`, `.TextGrid`, `.txt` (Audacity labels), or `.json` (an export of Label Studio).

    Raises:
        MossarError: If there is no such format, its library is missing, or the file cannot be read.
    """
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise AnnotationError(
            f"{path}: annotations are read from .eaf, .TextGrid, .txt (Audacity) and .json (Label Studio)"
        )
    if reader in (_read_eaf, _read_textgrid):
        needed("pympi", EXTRA, str(path))
    try:
        if path.stat().st_size > MAX_BYTES:
            raise AnnotationError(f"{path}: larger than {MAX_BYTES >> 20} MiB; this is no annotation file")
        return reader(path)
    except OSError as error:
        raise AnnotationError(f"{path}: cannot be read: {error.strerror or error}") from None


def _read_eaf(path: Path) -> list[Tier]:
    from pympi import Elan

    try:
        document = Elan.Eaf(str(path), suppress_version_warning=True)
        return [
            _tier(
                name,
                [
                    Mark(row[0] / 1000, row[1] / 1000, row[2] or "")
                    for row in document.get_annotation_data_for_tier(name)
                ],
            )
            for name in document.get_tier_names()
        ]
    except OSError:
        raise
    except Exception as error:  # noqa: BLE001 - pympi raises that class itself
        raise AnnotationError(f"{path}: no ELAN document: {error}") from None


def _read_textgrid(path: Path) -> list[Tier]:
    from pympi import Praat

    try:
        grid = Praat.TextGrid(str(path), codec="utf-8")
        tiers = []
        for own in grid.get_tiers():
            moments = own.tier_type == "TextTier"
            rows = own.get_all_intervals() if moments else own.get_intervals(sort=True)
            marks = [Mark(row[0], row[0] if moments else row[1], row[-1]) for row in rows if row[-1]]
            tiers.append(_tier(own.name, marks))
    except (ValueError, KeyError, TypeError, AttributeError, IndexError, UnicodeError) as error:  # as above
        raise AnnotationError(f"{path}: no TextGrid: {error}") from None
    except (StopIteration, RuntimeError):  # where pympi finds no line that it looks for
        raise AnnotationError(f"{path}: no TextGrid: a line is missing") from None
    return tiers


def _read_audacity(path: Path) -> list[Tier]:
    tiers: dict[str, list[Mark]] = defaultdict(list)
    for number, line in enumerate(path.read_text("utf-8", errors="replace").splitlines(), 1):
        if not line.strip() or line.startswith("\\"):  # a second line of a label holds its frequencies
            continue
        start, _, rest = line.partition("\t")
        end, _, label = rest.partition("\t")
        name, colon, own = label.partition(": ")
        try:
            mark = Mark(float(start), float(end), own if colon else label)
        except ValueError:
            raise AnnotationError(f"{path}, line {number}: not start, end and label between tabs") from None
        tiers[name if colon else "labels"].append(mark)
    return [_tier(name, marks) for name, marks in tiers.items()]


def _read_label_studio(path: Path) -> list[Tier]:
    try:
        tasks = msgspec.json.decode(path.read_bytes(), type=list[dict[str, Any]])
        tiers: dict[str, list[Mark]] = defaultdict(list)
        for task in tasks:
            for annotation in task.get("annotations") or ():
                for result in annotation.get("result") or ():
                    value = result["value"]
                    labels = next((value[key] for key in value if key.endswith("labels")), [""])
                    mark = Mark(float(value["start"]), float(value["end"]), str(labels[0]))
                    tiers[str(result.get("from_name", "labels"))].append(mark)
    except (msgspec.MsgspecError, KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        raise AnnotationError(f"{path}: no export of Label Studio: {error!r}") from None
    return [_tier(name, marks) for name, marks in tiers.items()]


def _tier(name: str, marks: list[Mark]) -> Tier:
    ordered = tuple(sorted(marks))
    return Tier(name, ordered, moments=bool(marks) and all(mark.end == mark.start for mark in marks))


_READERS = {
    ".eaf": _read_eaf,
    ".textgrid": _read_textgrid,
    ".txt": _read_audacity,
    ".json": _read_label_studio,
}
SUFFIXES = frozenset(_READERS)
