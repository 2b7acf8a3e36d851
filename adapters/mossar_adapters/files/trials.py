"""Trials: parts of C3D and TRC files in their own formats, every number as it was written."""

from pathlib import Path

from mossar_adapters.files.c3d import layout_of
from mossar_adapters.files.c3d_copy import C3dCopy
from mossar_adapters.files.c3d_parameters import read_parameters
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.text import numbered_lines

_LAST = 65536  # words of 16 bits


def write_c3d_trial(source: Path, target: Path, start: int, end: int) -> None:
    """Write frames of a C3D file, with their analogue samples, events and all other parameters.

    Frames keep their numbers, so events keep their times.

    Args:
        source: The recording.
        target: The part.
        start: First frame, from 0.
        end: The frame behind the last.

    Raises:
        FileError: If the source is damaged.
        OutputError: If the part cannot be written.
    """
    header, machine, parameters = read_parameters(source)
    layout = layout_of(source, header, machine, parameters)
    first, last = layout.first_frame + start + 1, layout.first_frame + end
    copy = C3dCopy(source)
    copy.keep(layout.start, layout.start + start * layout.frame_size, (end - start) * layout.frame_size)
    copy.set_range(first, last)
    copy.set_words(
        {
            "POINT:FRAMES": [end - start],
            "TRIAL:ACTUAL_START_FIELD": [first % _LAST, first // _LAST],
            "TRIAL:ACTUAL_END_FIELD": [last % _LAST, last // _LAST],
        }
    )
    copy.write(target)


def trc_lines(path: Path) -> tuple[list[str], list[str]]:
    """Return the heading of a TRC file and its rows, as they were written.

    Raises:
        FileError: If there is no line of marker names.
    """
    head: list[str] = []
    rows: list[str] = []
    named = False
    for _, text in numbered_lines(path):
        cells = text.replace('"', "").replace(",", "\t").replace(";", "\t").split()
        if rows or (named and cells and cells[0].lstrip("-").isdigit()):
            rows += [text] if cells else []
            continue
        head.append(text)
        named = named or bool(cells and cells[0].lower().rstrip("#") == "frame")
    if not named:
        raise FileError(path, "there is no line of marker names")
    return head, rows


def trc_part(head: list[str], rows: list[str]) -> str:
    """Return a TRC file with some of the rows; the number of frames in its heading is theirs."""
    lines = list(head)
    for number, text in enumerate(head[:-1]):
        names = text.split("\t")
        values = head[number + 1].split("\t")
        places = [i for i, name in enumerate(names) if name.strip().lower() == "numframes"]
        if places and places[0] < len(values):
            values[places[0]] = str(len(rows))
            lines[number + 1] = "\t".join(values)
    return "\n".join([*lines, *rows, ""])
