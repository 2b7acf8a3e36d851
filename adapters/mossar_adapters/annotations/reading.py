"""Reading annotations back: corrections by hand, as tiers."""

import codecs
import html
import math
import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import msgspec

from mossar_adapters.annotations.c3d import read_c3d_events
from mossar_adapters.annotations.tables import as_written, read_bids, read_table
from mossar_adapters.annotations.tiers import AnnotationError, Mark, Tier
from mossar_adapters.annotations.writing import EXTRA
from mossar_adapters.extras import needed
from mossar_adapters.regular import check_regular

MAX_BYTES = 64 << 20
_CLOCK = r"(?:(\d{1,6}):)?(\d\d):(\d\d\.\d{3})"
_TIMING = re.compile(rf"\s*{_CLOCK}\s+-->\s+{_CLOCK}(?:\s|$)")


def chosen_tier(path: str | Path, wanted: str | None, usual: Sequence[str]) -> Tier:
    """Return a tier of an annotation file.

    Args:
        path: See `read_annotations`.
        wanted: Its name; None for the first of the usual ones that is there, or else the only one there is.
        usual: Names.

    Raises:
        MossarError: If the file cannot be read, or the wanted tier is not clear.
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


def read_annotations(path: str | Path) -> list[Tier]:
    """Return the tiers of a file.

    Args:
        path: `.eaf` (ELAN), `.TextGrid` (Praat), `.txt` (Audacity labels), `.vtt` (WebVTT), `.tsv` (BIDS events), `.csv` (a
            table with columns start and end), `.json` (Label Studio: annotations, or else predictions) or `.c3d` (its events).

    Raises:
        MossarError: If there is no such format, its library is missing, or the file cannot be read.
    """
    path = Path(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise AnnotationError(
            f"{path}: annotations are read from .eaf, .TextGrid, .txt (Audacity), .vtt, .tsv (BIDS), .csv, .json (Label "
            "Studio) and .c3d (events)"
        )
    if reader in (_read_eaf, _read_textgrid):
        needed("pympi", EXTRA, str(path))
    try:
        check_regular(path)
        if reader is not read_c3d_events and path.stat().st_size > MAX_BYTES:
            raise AnnotationError(f"{path}: larger than {MAX_BYTES >> 20} MiB; this is no annotation file")
        return [_checked(path, tier) for tier in reader(path)]
    except OSError as error:
        raise AnnotationError(f"{path}: cannot be read: {error.strerror or error}") from None


def _checked(path: Path, tier: Tier) -> Tier:
    """Return a tier if its times are possible."""
    for mark in tier.marks:
        if not (math.isfinite(mark.start) and math.isfinite(mark.end)):
            raise AnnotationError(f"{path}: tier {tier.name}: a time is no number")
        if mark.end < mark.start:
            raise AnnotationError(
                f"{path}: tier {tier.name}: the mark at {mark.start:g} s ends before its start"
            )
    return tier


def _read_eaf(path: Path) -> list[Tier]:
    from pympi import Elan

    try:
        document = Elan.Eaf(str(path), suppress_version_warning=True)
        return [
            _elan_tier(name, document.get_annotation_data_for_tier(name))
            for name in document.get_tier_names()
        ]
    except OSError:
        raise
    except Exception as error:  # noqa: BLE001 - pympi raises that class itself
        raise AnnotationError(f"{path}: no ELAN document: {error}") from None


def _elan_tier(name: str, rows: Sequence[tuple[Any, ...]]) -> Tier:
    """Return a tier of ELAN, whose rows are start, end (ms) and label; of moments where all of them last one millisecond."""
    least = all(row[1] - row[0] == 1 for row in rows)
    return _tier(name, [Mark(row[0] / 1000, row[0 if least else 1] / 1000, row[2] or "") for row in rows])


def _read_textgrid(path: Path) -> list[Tier]:
    from pympi import Praat

    try:
        grid = Praat.TextGrid(str(path), codec=_praat_codec(path))
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


def _praat_codec(path: Path) -> str:
    """Return the encoding of a TextGrid: Praat writes UTF-16 where a label is not ASCII."""
    with path.open("rb") as file:
        mark = file.read(3)
    if mark[:2] in (codecs.BOM_UTF16_BE, codecs.BOM_UTF16_LE):
        return "utf-16"
    return "utf-8-sig" if mark == codecs.BOM_UTF8 else "utf-8"


def _read_audacity(path: Path) -> list[Tier]:
    tiers: dict[str, list[Mark]] = defaultdict(list)
    for number, line in enumerate(path.read_text("utf-8-sig", errors="replace").splitlines(), 1):
        if not line.strip() or line.startswith("\\"):  # a second line of a label holds its frequencies
            continue
        start, _, rest = line.partition("\t")
        end, _, label = rest.partition("\t")
        name, own = _parted(label)
        try:
            mark = Mark(float(start), float(end), own)
        except ValueError:
            raise AnnotationError(f"{path}, line {number}: not start, end and label between tabs") from None
        tiers[name].append(mark)
    return [_tier(name, marks) for name, marks in tiers.items()]


def _parted(text: str) -> tuple[str, str]:
    """Return tier and label of `tier: label`."""
    name, colon, label = text.partition(": ")
    return (name, label) if colon else ("labels", text)


def _read_vtt(path: Path) -> list[Tier]:
    tiers: dict[str, list[Mark]] = defaultdict(list)
    lines = path.read_text("utf-8-sig", errors="replace").splitlines()
    if not lines or not lines[0].startswith("WEBVTT"):
        raise AnnotationError(f"{path}: no WebVTT: the first line is not WEBVTT")
    for number, block in _blocks(lines):
        timing = next((i for i, line in enumerate(block[:2]) if "-->" in line), None)
        if timing is None:  # a note, a style, a region
            continue
        found = _TIMING.match(block[timing])
        if found is None:
            raise AnnotationError(f"{path}, line {number + timing}: not a time, --> and another")
        start, end = (
            3600.0 * int(found[k] or 0) + 60.0 * int(found[k + 1]) + float(found[k + 2]) for k in (1, 4)
        )
        text = html.unescape(re.sub(r"<[^>]*>", "", " ".join(block[timing + 1 :])))
        name, label = _parted(text)
        tiers[name].append(Mark(start, end, label))
    return [_tier(name, marks) for name, marks in tiers.items()]


def _blocks(lines: Sequence[str]) -> Iterator[tuple[int, list[str]]]:
    """Yield the blocks between empty lines, each with the number of its first line."""
    block: list[str] = []
    for number, line in enumerate([*lines, ""], 1):
        if line.strip():
            block.append(line)
        elif block:
            yield number - len(block), block
            block = []


def _read_label_studio(path: Path) -> list[Tier]:
    try:
        tasks = msgspec.json.decode(path.read_bytes(), type=list[dict[str, Any]])
        tiers: dict[str, list[Mark]] = defaultdict(list)
        for task in tasks:
            for annotation in task.get("annotations") or task.get("predictions") or ():
                for result in annotation.get("result") or ():
                    name = as_written(str(result.get("from_name", "labels")))
                    tiers[name] += _marks(path, result["value"], task.get("data") or {})
    except (msgspec.MsgspecError, KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        raise AnnotationError(f"{path}: no export of Label Studio: {error!r}") from None
    except RecursionError:
        raise AnnotationError(f"{path}: no export of Label Studio: it is nested too deeply") from None
    return [_tier(name, marks) for name, marks in tiers.items()]


def _marks(path: Path, value: dict[str, Any], data: dict[str, Any]) -> list[Mark]:
    """Return the marks of a result of Label Studio: seconds of a time series, or frames, from 1, of a video."""
    labels = next((value[key] for key in value if key.endswith("labels")), [""])
    if "ranges" not in value:
        return [Mark(float(value["start"]), float(value["end"]), str(labels[0]))]
    fps = data.get("fps")
    if not isinstance(fps, int | float) or not 0 < fps <= 1e5:
        raise AnnotationError(
            f"{path}: it labels frames of a video; fps, in the data of each task, says how fast they are"
        )
    spans = [(int(own["start"]), int(own["end"])) for own in value["ranges"]]
    return [Mark((begin - 1) / fps, (end - 1) / fps, str(labels[0])) for begin, end in spans]


def _tier(name: str, marks: list[Mark]) -> Tier:
    ordered = tuple(sorted(marks))
    return Tier(name, ordered, moments=bool(marks) and all(mark.end == mark.start for mark in marks))


_READERS = {
    ".eaf": _read_eaf,
    ".textgrid": _read_textgrid,
    ".txt": _read_audacity,
    ".json": _read_label_studio,
    ".vtt": _read_vtt,
    ".tsv": read_bids,
    ".csv": read_table,
    ".c3d": read_c3d_events,
}
SUFFIXES = frozenset(_READERS)
