"""Writing annotations: the suffix of the file chooses the program."""

from collections.abc import Callable, Sequence
from pathlib import Path, PurePath
from typing import NamedTuple

from mossar_adapters.annotations.tiers import AnnotationError, Mark, Tier
from mossar_adapters.extras import installed, needed
from mossar_adapters.files.replacing import Draft
from mossar_adapters.table_text import cell

EXTRA, _LIBRARY = "annotate", "pympi"


def has_format(path: PurePath) -> bool:
    """Return whether there is a format for a file."""
    return path.suffix.lower() in _BY_SUFFIX


def check_annotations(path: str | Path) -> None:
    """Check that there is a format for a file and that its library is installed.

    Raises:
        MossarError: If not.
    """
    _format_of(Path(path))


def write_annotations(path: str | Path, tiers: Sequence[Tier], duration: float) -> None:
    """Write tiers to a file.

    Args:
        path: `.eaf` (ELAN), `.TextGrid` (Praat), `.txt` (Audacity labels), `.vtt` (WebVTT), `.tsv` (BIDS events).
        tiers: The tiers to write.
        duration: Of the recording, s.

    Raises:
        MossarError: If there is no such format, its library is missing, or the file cannot be written.
    """
    path = Path(path)
    found = _format_of(path)
    try:
        with Draft(path) as draft:
            found.write(draft.path, tiers, duration)
    except OSError as error:
        raise AnnotationError(f"{path}: cannot be written: {error.strerror or error}") from None


def _format_of(path: Path) -> "AnnotationFormat":
    found = _BY_SUFFIX.get(path.suffix.lower())
    if found is None:
        *others, last = (f"{row.suffix} ({row.program})" for row in FORMATS)
        raise AnnotationError(
            f"{path}: no annotation format is called {path.suffix or 'nothing'}; there are {', '.join(others)} and {last}"
        )
    if found.extra is not None:
        needed(_LIBRARY, found.extra, str(path))
    return found


def _write_eaf(path: Path, tiers: Sequence[Tier], _: float) -> None:
    """Write ELAN's format, whose times are whole milliseconds and whose moments last one."""
    from pympi import Elan

    document = Elan.Eaf(author="mossar-stream")
    document.remove_tier("default")
    for tier in tiers:
        document.add_tier(tier.name)
        for mark in tier.marks:
            start = round(mark.start * 1000)
            document.add_annotation(tier.name, start, max(round(mark.end * 1000), start + 1), mark.label)
    path.unlink()  # pympi keeps a copy of a file that it replaces
    Elan.to_eaf(str(path), document)


def _write_template(path: Path, tiers: Sequence[Tier], _: float) -> None:
    """Write a template of ELAN: the tiers without marks, each with a controlled vocabulary of its labels."""
    from pympi import Elan

    document = Elan.Eaf(author="mossar-stream")
    document.remove_tier("default")
    for number, tier in enumerate(tiers, 1):
        labels = list(dict.fromkeys(mark.label for mark in tier.marks))
        kind, words = f"labels {number}", f"words of {tier.name}"
        document.add_controlled_vocabulary(words)
        document.add_language("und")
        for entry, label in enumerate(labels):
            document.add_cv_entry(words, f"w{number}_{entry}", [(label, "und", None)])
        own = {"LINGUISTIC_TYPE_ID": kind, "TIME_ALIGNABLE": "true", "GRAPHIC_REFERENCES": "false"}
        document.add_linguistic_type(kind, param_dict={**own, "CONTROLLED_VOCABULARY_REF": words})
        document.add_tier(tier.name, kind)
    path.unlink()
    Elan.to_eaf(str(path), document)


def _write_textgrid(path: Path, tiers: Sequence[Tier], duration: float) -> None:
    from pympi import Praat

    grid = Praat.TextGrid(xmin=0, xmax=max([duration, *(m.end for t in tiers for m in t.marks)]))
    for tier in tiers:
        name = tier.name.replace('"', '""')  # as Praat wants it, which pympi does for labels only
        own = grid.add_tier(name, "TextTier" if tier.moments else "IntervalTier")
        for mark in tier.marks:
            if tier.moments:
                own.add_point(mark.start, mark.label, check=False)
            else:
                own.add_interval(mark.start, mark.end, mark.label, check=False)
    grid.to_file(str(path))


def _write_audacity(path: Path, tiers: Sequence[Tier], _: float) -> None:
    """Write Audacity's labels, which have no tiers: the tier stands before the label."""
    lines = [f"{m.start:.6f}\t{m.end:.6f}\t{name}: {m.label}\n" for m, name in _in_order(tiers)]
    path.write_text("".join(lines), encoding="utf-8")


def _write_vtt(path: Path, tiers: Sequence[Tier], _: float) -> None:
    """Write WebVTT cues; moments are left out, because a cue must last."""
    cues = [
        f"{_clock(mark.start)} --> {_clock(mark.end)}\n{_escaped(name)}: {_escaped(mark.label)}\n"
        for mark, name in _in_order(tiers)
        if round(mark.end * 1000) > round(mark.start * 1000)
    ]
    path.write_text("\n".join(["WEBVTT\n", *cues]), encoding="utf-8")


def _write_bids(path: Path, tiers: Sequence[Tier], _: float) -> None:
    """Write the events table of the Brain Imaging Data Structure."""
    rows = [
        f"{m.start:.6f}\t{m.end - m.start:.6f}\t{cell(name.replace(' ', '_'))}\t{cell(m.label)}\n"
        for m, name in _in_order(tiers)
    ]
    path.write_text("".join(["onset\tduration\ttrial_type\tvalue\n", *rows]), encoding="utf-8")


def _in_order(tiers: Sequence[Tier]) -> list[tuple[Mark, str]]:
    """Return all marks for formats whose lines end a mark and whose tabs part its cells."""
    return sorted(
        (Mark(mark.start, mark.end, _in_one_line(mark.label)), _in_one_line(tier.name))
        for tier in tiers
        for mark in tier.marks
    )


def _in_one_line(text: str) -> str:
    return " ".join(text.replace("\t", "\n").splitlines())


def _clock(seconds: float) -> str:
    minutes, milliseconds = divmod(round(seconds * 1000), 60_000)
    hours, minutes = divmod(minutes, 60)
    return f"{hours:02d}:{minutes:02d}:{milliseconds // 1000:02d}.{milliseconds % 1000:03d}"


def _escaped(label: str) -> str:
    return label.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


class AnnotationFormat(NamedTuple):
    """A format of annotations.

    Args:
        suffix: Of its files.
        program: That reads them.
        write: Writes tiers of a recording of so many seconds.
        extra: Extra that it needs; None for none.
    """

    suffix: str
    program: str
    write: Callable[[Path, Sequence[Tier], float], None]
    extra: str | None = None

    def available(self) -> bool:
        """Return whether its library is installed."""
        return self.extra is None or installed(_LIBRARY)


FORMATS = (
    AnnotationFormat(".eaf", "ELAN", _write_eaf, EXTRA),
    AnnotationFormat(".etf", "ELAN template", _write_template, EXTRA),
    AnnotationFormat(".TextGrid", "Praat", _write_textgrid, EXTRA),
    AnnotationFormat(".txt", "Audacity labels", _write_audacity),
    AnnotationFormat(".vtt", "WebVTT", _write_vtt),
    AnnotationFormat(".tsv", "BIDS events", _write_bids),
)
SUFFIXES = tuple(row.suffix for row in FORMATS)
_BY_SUFFIX = {row.suffix.lower(): row for row in FORMATS}
