"""Writing annotations: the suffix of the file says for which program."""

from collections.abc import Callable, Sequence
from pathlib import Path, PurePath

from mossar_adapters.annotations.tiers import AnnotationError, Mark, Tier
from mossar_adapters.extras import needed

EXTRA = "annotate"


def has_format(path: PurePath) -> bool:
    """Return whether there is a format for a file."""
    return path.suffix.lower() in _WRITERS


def check_annotations(path: Path) -> None:
    """Check that there is a format for a file and that its library is installed.

    Raises:
        MossarError: If not.
    """
    _writer(path)


def write_annotations(path: Path, tiers: Sequence[Tier], duration: float) -> None:
    """Write tiers to a file.

    Args:
        path: `.eaf` (ELAN), `.TextGrid` (Praat), `.txt` (Audacity labels), `.vtt` (WebVTT), `.tsv` (BIDS events).
        tiers: What to write.
        duration: Of the recording, s.

    Raises:
        MossarError: If there is no such format, its library is missing, or the file cannot be written.
    """
    writer = _writer(path)
    try:
        writer(path, tiers, duration)
    except OSError as error:
        raise AnnotationError(f"{path}: cannot be written: {error.strerror or error}") from None


def _writer(path: Path) -> Callable[[Path, Sequence[Tier], float], None]:
    writer = _WRITERS.get(path.suffix.lower())
    if writer is None:
        raise AnnotationError(
            f"{path}: no annotation format is called {path.suffix or 'nothing'}; there are .eaf (ELAN), "
            ".TextGrid (Praat), .txt (Audacity), .vtt (WebVTT) and .tsv (BIDS events)"
        )
    if writer in (_write_eaf, _write_textgrid):
        needed("pympi", EXTRA, str(path))
    return writer


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
    path.unlink(missing_ok=True)  # pympi keeps a copy of what it replaces
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
        f"{_clock(mark.start)} --> {_clock(mark.end)}\n{name}: {_escaped(mark.label)}\n"
        for mark, name in _in_order(tiers)
        if round(mark.end * 1000) > round(mark.start * 1000)
    ]
    path.write_text("\n".join(["WEBVTT\n", *cues]), encoding="utf-8")


def _write_bids(path: Path, tiers: Sequence[Tier], _: float) -> None:
    """Write the events table of the Brain Imaging Data Structure."""
    rows = [
        f"{m.start:.6f}\t{m.end - m.start:.6f}\t{name.replace(' ', '_')}\t{m.label}\n"
        for m, name in _in_order(tiers)
    ]
    path.write_text("".join(["onset\tduration\ttrial_type\tvalue\n", *rows]), encoding="utf-8")


def _in_order(tiers: Sequence[Tier]) -> list[tuple[Mark, str]]:
    return sorted((mark, tier.name) for tier in tiers for mark in tier.marks)


def _clock(seconds: float) -> str:
    minutes, milliseconds = divmod(round(seconds * 1000), 60_000)
    hours, minutes = divmod(minutes, 60)
    return f"{hours:02d}:{minutes:02d}:{milliseconds // 1000:02d}.{milliseconds % 1000:03d}"


def _escaped(label: str) -> str:
    return label.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


_WRITERS: dict[str, Callable[[Path, Sequence[Tier], float], None]] = {
    ".eaf": _write_eaf,
    ".textgrid": _write_textgrid,
    ".txt": _write_audacity,
    ".vtt": _write_vtt,
    ".tsv": _write_bids,
}
SUFFIXES = (".eaf", ".TextGrid", ".txt", ".vtt", ".tsv")
