"""CSV: one row per frame, headed columns.

Our own layout, which is also the one to write when exporting from elsewhere::

    # fps=60 unit=m root=hips parents=-1,0,1
    time,hips.x,hips.y,hips.z,spine.x,spine.y,spine.z,head.x,head.y,head.z
    0.0,0.01,0.95,0.0,0.01,1.2,0.0,0.02,1.6,0.0

The comment line and each of its words are optional, the time too; an empty cell is a missing coordinate;
`hips.confidence` (0 to 1) may be added for all joints. Tables of other programs with such columns read as well:
semicolons, tabs, decimal commas, headings of one or two lines and other spellings (see `heading`, `columns`),
Kinect tables, numbered landmarks of pose estimators, rows of several people who take turns (`person_id`).
"""

import re
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.assembly import first_chunk, in_metres, sane_frames, scaled_by_height, skeleton_of
from mossar_adapters.files.bodies import bodies_of, by_body
from mossar_adapters.files.cells import numbers
from mossar_adapters.files.clock import seconds, unit_of_steps
from mossar_adapters.files.columns import Columns
from mossar_adapters.files.errors import FileError, shown
from mossar_adapters.files.heading import Heading, read_heading
from mossar_adapters.files.missing import without_nobody, without_zeros
from mossar_adapters.files.options import METRES, ReadOptions, plausible_rate
from mossar_adapters.files.rates import USUAL_FPS, assumed_rate, rate_of_times
from mossar_adapters.files.rows import Block, Rows, cut_note, survey
from mossar_adapters.files.units import fitted_scale, guessed_scale, metres_of, stated_scale
from mossar_adapters.joint_sets import (
    BLAZEPOSE_33,
    COCO_17,
    KINECT_20,
    KINECT_25,
    by_count,
    with_known_parents,
)
from mossar_adapters.source import Recording
from mossar_stream import Frames, Skeleton, constant_times

_KINECT = {*KINECT_20.names, *KINECT_25.names}


def read(path: Path, options: ReadOptions) -> Recording:
    """Read a table of joint positions."""
    heading = read_heading(path)
    columns = heading.columns
    rows = survey(path, heading.first_line, heading.split, heading.width)
    bodies = bodies_of(rows, columns.body)
    fps, time_unit, notes = _clock(path, heading, rows, bodies, options)
    zeros = set(columns.joints) <= _KINECT and not _is_centred(rows, columns)

    def chunks() -> Iterator[Frames]:
        for body, block in by_body(rows.blocks(), columns.body) if bodies else _alone(rows):
            if bodies and body not in bodies:
                continue
            positions, confidence = _positions(block, rows, columns)
            times = _stamps(block, rows, columns) * time_unit if time_unit else None
            yield sane_frames(
                without_zeros(positions) if zeros else without_nobody(positions),
                constant_times(len(positions), fps or USUAL_FPS, block.start) if times is None else times,
                confidence,
                bodies[body][0] if bodies else "p1",
            )

    skeleton = _skeleton(path, columns, heading.metadata)
    count = sum(count for _, count in bodies.values()) or rows.count
    performers = tuple(name for name, _ in bodies.values()) or ("p1",)
    recording = Recording(str(path), skeleton, fps, chunks, (*cut_note(rows), *notes), count, performers)
    unit = heading.metadata.get("unit", "auto")
    metres = metres_of(unit)
    if unit != "auto" and metres is None:
        raise FileError(path, f"unit={unit[:20]} is none of {', '.join(METRES)}")
    if metres is not None:
        return in_metres(recording, stated_scale(options, metres))
    if set(columns.joints) <= _KINECT:
        return in_metres(recording, stated_scale(options, 1.0))  # the sensor's camera space
    normalised = _is_normalised(skeleton.names, first_chunk(path, chunks).positions)
    return scaled_by_height(
        recording, lambda tall: (fitted_scale if normalised else guessed_scale)(options, tall)
    )


def _alone(rows: Rows) -> Iterator[tuple[str, Block]]:
    return (("", block) for block in rows.blocks())


def _positions(
    block: Block, rows: Rows, columns: Columns
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Return (n, J, 3) in the file's unit and (n, J) or None."""
    wanted = [column for xyz in columns.xyz for column in xyz] + list(columns.confidence)
    values = numbers([[row[c] for c in wanted] for row in block.cells], rows.path, block.lines)
    joints = len(columns.xyz)
    positions = values[:, : 3 * joints].reshape(len(values), joints, 3)
    return positions, values[:, 3 * joints :] if columns.confidence else None


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
    path: Path, heading: Heading, rows: Rows, bodies: Collection[str], options: ReadOptions
) -> tuple[float | None, float | None, tuple[str, ...]]:
    """Return the rate, the seconds per unit of the time column (None to count frames instead), and notes."""
    if options.fps is not None:
        return options.fps, None, ()
    columns = heading.columns
    stated = _stated_rate(path, heading.metadata)
    if columns.time < 0:
        if stated is not None:
            return stated, None, ()
        return USUAL_FPS, None, (assumed_rate("the file has neither times nor fps"),)
    first = next(rows.blocks())
    if bodies:
        parts = [part for body, part in by_body(iter([first]), columns.body) if body in bodies]
        first = max(parts, key=lambda part: len(part.lines), default=first)
    stamps = _stamps(first, rows, columns)
    unit, notes = columns.time_unit, tuple[str, ...]()
    if unit is None and ":" in first.cells[0][columns.time]:
        unit = 1.0
    if unit is None:
        unit, name = unit_of_steps(stamps)
        notes = () if name == "s" else (f"times taken as {name}",)
    return stated or rate_of_times(stamps * unit), unit, notes


def _stated_rate(path: Path, metadata: dict[str, str]) -> float | None:
    if "fps" not in metadata:
        return None
    try:
        fps = float(metadata["fps"])
    except ValueError:
        fps = float("nan")
    if not plausible_rate(fps):
        raise FileError(path, f"fps={shown(metadata['fps'])} is no possible rate")
    return fps


def _skeleton(path: Path, columns: Columns, metadata: dict[str, str]) -> Skeleton:
    names = _known_names(columns.joints)
    parents: Sequence[int]
    parents, root = with_known_parents(names)
    if "parents" in metadata:
        words = metadata["parents"].split(",")
        if len(words) != len(names) or not all(word.removeprefix("-").isdecimal() for word in words):
            raise FileError(path, f"parents= does not give one index for each of {len(names)} joints")
        parents = [int(word[:6]) for word in words]
    if "root" in metadata:
        if metadata["root"] not in names:
            raise FileError(path, f"root={shown(metadata['root'])} is not a joint")
        root = names.index(metadata["root"])
    return skeleton_of(path, names, parents, root)


def _known_names(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of a known set where the file only numbers its joints (`x1`, `landmark_0_x`)."""
    found = [re.search(r"(\d{1,3})$", name) for name in names]
    numbers = [int(match[1]) for match in found if match]
    known = by_count(len(names))
    if known and numbers in (list(range(len(names))), list(range(1, len(names) + 1))):
        return known.names
    return names


def _is_normalised(names: tuple[str, ...], positions: NDArray[np.float32]) -> bool:
    """Return whether these are landmarks in shares of an image: all between 0 and 1, which no room is."""
    if not set(names) <= {*BLAZEPOSE_33.names, *COCO_17.names}:
        return False
    plane = positions[:, :, :2]
    inside = (plane > -0.2) & (plane < 1.2)
    return bool(inside.mean() > 0.95 and (plane[np.isfinite(plane)] >= 0).mean() > 0.9)


def _is_centred(rows: Rows, columns: Columns) -> bool:
    """Return whether some joint is always at the origin, as in recordings relative to the hips."""
    positions, _ = _positions(next(rows.blocks()), rows, columns)
    at_origin = (positions == 0).all(axis=2)  # (n, J)
    return bool(at_origin.all(axis=0).any() and not at_origin.all())
