"""CSV: one row per frame, headed columns.

Our own layout, which is also the one to write when exporting from elsewhere::

    # fps=60 unit=m root=hips parents=-1,0,1
    time,hips.x,hips.y,hips.z,spine.x,spine.y,spine.z,head.x,head.y,head.z
    0.0,0.01,0.95,0.0,0.01,1.2,0.0,0.02,1.6,0.0

The comment line and each of its words are optional, the time too; an empty cell is a missing coordinate;
`hips.confidence` (0 to 1) may be added for all joints. Tables of other programs with such columns read as well:
semicolons, tabs, decimal commas, other spellings of the headings (see `columns`), Kinect tables.
"""

import csv
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.assembly import in_metres, sane_frames, scaled_by_height, skeleton_of
from mossar_adapters.files.cells import numbers
from mossar_adapters.files.clock import seconds, unit_of_steps
from mossar_adapters.files.columns import Columns, find_columns
from mossar_adapters.files.errors import FileError, shown
from mossar_adapters.files.missing import without_zeros
from mossar_adapters.files.options import METRES, ReadOptions, plausible_rate
from mossar_adapters.files.rates import rate_of_times
from mossar_adapters.files.rows import Block, Rows, cut_note, survey
from mossar_adapters.files.text import numbered_lines
from mossar_adapters.files.units import given, guessed
from mossar_adapters.joint_sets import KINECT_20, KINECT_25, with_known_parents
from mossar_adapters.source import Recording
from mossar_stream.frames import Frames, constant_times
from mossar_stream.skeleton import Skeleton

USUAL_FPS = 30.0
MAX_PREAMBLE = 50  # lines before the headings
_KINECT = {*KINECT_20.names, *KINECT_25.names}


class Preamble(msgspec.Struct, frozen=True):
    """What stands before the rows.

    Args:
        facts: Words `key=value` of comment lines.
        columns: By the headings.
        first_line: Number of the first line after the headings.
        split: Makes cells of a line.
        width: Number of headings.
    """

    facts: dict[str, str]
    columns: Columns
    first_line: int
    split: Callable[[str], list[str]]
    width: int


def read(path: Path, options: ReadOptions) -> Recording:
    """Read a table of joint positions."""
    preamble = _preamble(path)
    columns = preamble.columns
    rows = survey(path, preamble.first_line, preamble.split, preamble.width)
    fps, time_unit, notes = _clock(path, preamble, rows, options)
    zeros = set(columns.joints) <= _KINECT and not _is_centred(rows, columns)

    def chunks() -> Iterator[Frames]:
        for block in rows.blocks():
            positions, confidence = _positions(block, rows, columns)
            times = _times(block, rows, columns, time_unit) if time_unit else None
            yield sane_frames(
                without_zeros(positions) if zeros else positions,
                constant_times(len(positions), fps or USUAL_FPS, block.start) if times is None else times,
                confidence,
            )

    skeleton = _skeleton(path, columns, preamble.facts)
    recording = Recording(str(path), skeleton, fps, chunks, (*cut_note(rows), *notes), rows.count)
    unit = preamble.facts.get("unit", "auto")
    if unit != "auto" and unit not in METRES:
        raise FileError(path, f"unit={unit[:20]} is none of {', '.join(METRES)}")
    if unit in METRES:
        return in_metres(recording, given(options, METRES[unit]))
    if set(columns.joints) <= _KINECT:
        return in_metres(recording, given(options, 1.0))  # the sensor's camera space
    return scaled_by_height(recording, lambda tall: guessed(options, tall))


def splitter(delimiter: str | None, *, decimal_comma: bool = False) -> Callable[[str], list[str]]:
    """Return a function that makes cells of a line.

    Args:
        delimiter: One character, or None for any white space.
        decimal_comma: Whether numbers are written `0,5`.
    """

    def split(text: str) -> list[str]:
        if decimal_comma:
            text = text.replace(",", ".")
        if delimiter and '"' in text:
            return next(csv.reader([text], delimiter=delimiter), [])
        return text.split(delimiter)

    return split


def delimiter_of(header: str) -> str | None:
    """Return what separates headings: the most frequent of tab, semicolon and comma, else white space."""
    best = max("\t;,", key=header.count)
    return best if best in header else None


def _preamble(path: Path) -> Preamble:
    facts: dict[str, str] = {}
    lines = numbered_lines(path)
    for line, text in lines:
        if line > MAX_PREAMBLE:
            break
        if text.startswith("#"):
            facts.update(word.partition("=")[::2] for word in text[1:].split() if "=" in word)
            continue
        delimiter = delimiter_of(text)
        header = splitter(delimiter)(text)
        columns = find_columns(header)
        if columns:
            sample = next((text for _, text in lines if text.strip()), "")
            decimal_comma = delimiter != "," and "," in sample and "." not in sample
            split = splitter(delimiter, decimal_comma=decimal_comma)
            return Preamble(facts, columns, line + 1, split, _last_column(columns) + 1)
    raise FileError(path, "no headings with x, y and z of joints, such as: time,hips.x,hips.y,hips.z")


def _last_column(columns: Columns) -> int:
    return max(columns.time, *columns.confidence, *(c for xyz in columns.xyz for c in xyz))


def _positions(
    block: Block, rows: Rows, columns: Columns
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Return (n, J, 3) in the file's unit and (n, J) or None."""
    wanted = [column for xyz in columns.xyz for column in xyz] + list(columns.confidence)
    values = numbers([[row[c] for c in wanted] for row in block.cells], rows.path, block.lines)
    joints = len(columns.xyz)
    positions = values[:, : 3 * joints].reshape(len(values), joints, 3)
    return positions, values[:, 3 * joints :] if columns.confidence else None


def _times(block: Block, rows: Rows, columns: Columns, unit: float) -> NDArray[np.float64]:
    return _stamps(block, rows, columns) * unit


def _stamps(block: Block, rows: Rows, columns: Columns) -> NDArray[np.float64]:
    """Return (n,) times as the column has them."""
    stamps = np.empty(len(block.cells))
    for i, row in enumerate(block.cells):
        try:
            stamps[i] = seconds(row[columns.time])
        except (ValueError, OverflowError):
            stamps[i] = np.nan
        if not np.isfinite(stamps[i]):
            raise FileError(rows.path, f"{shown(row[columns.time])} is no time", block.lines[i])
    return stamps


def _clock(
    path: Path, preamble: Preamble, rows: Rows, options: ReadOptions
) -> tuple[float | None, float | None, tuple[str, ...]]:
    """Return the rate, the seconds per unit of the time column (None to count frames instead), and notes."""
    if options.fps is not None:
        return options.fps, None, ()
    columns = preamble.columns
    stated = _stated_rate(path, preamble.facts)
    if columns.time < 0:
        if stated is not None:
            return stated, None, ()
        note = f"rate taken as {USUAL_FPS:.0f} Hz (the file has neither times nor fps); set fps to change"
        return USUAL_FPS, None, (note,)
    first = next(rows.blocks())
    stamps = _stamps(first, rows, columns)
    unit, notes = columns.time_unit, tuple[str, ...]()
    if unit is None and ":" in first.cells[0][columns.time]:
        unit = 1.0
    if unit is None:
        unit, name = unit_of_steps(stamps)
        notes = () if name == "s" else (f"times taken as {name}",)
    return stated or rate_of_times(stamps * unit), unit, notes


def _stated_rate(path: Path, facts: dict[str, str]) -> float | None:
    if "fps" not in facts:
        return None
    try:
        fps = float(facts["fps"])
    except ValueError:
        fps = float("nan")
    if not plausible_rate(fps):
        raise FileError(path, f"fps={shown(facts['fps'])} is no possible rate")
    return fps


def _skeleton(path: Path, columns: Columns, facts: dict[str, str]) -> Skeleton:
    names = columns.joints
    parents: Sequence[int]
    parents, root = with_known_parents(names)
    if "parents" in facts:
        words = facts["parents"].split(",")
        if len(words) != len(names) or not all(word.lstrip("-").isdecimal() for word in words):
            raise FileError(path, f"parents= does not give one index for each of {len(names)} joints")
        parents = [int(word[:6]) for word in words]
    if "root" in facts:
        if facts["root"] not in names:
            raise FileError(path, f"root={shown(facts['root'])} is not a joint")
        root = names.index(facts["root"])
    return skeleton_of(path, names, parents, root)


def _is_centred(rows: Rows, columns: Columns) -> bool:
    """Return whether some joint is always at the origin, as in recordings relative to the hips."""
    positions, _ = _positions(next(rows.blocks()), rows, columns)
    at_origin = (positions == 0).all(axis=2)  # (n, J)
    return bool(at_origin.all(axis=0).any() and not at_origin.all())
