"""XDF: Lab Streaming Layer recordings; the stream of type MoCap.

Channels are found by their labels as in tables (`hip_x`, `hip_y`, `hip_z`) or by their types (`PositionX` …).
"""

import io
import logging
import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.assembly import in_stated_unit, sane_frames, skeleton_of
from mossar_adapters.files.columns import Columns, find_columns
from mossar_adapters.files.errors import FileError, shown
from mossar_adapters.files.options import ReadOptions, plausible_rate
from mossar_adapters.files.rates import rate_of_times
from mossar_adapters.files.rows import CHUNK
from mossar_adapters.files.xdf_chunks import Stream, checked_stream, streams_of
from mossar_adapters.joint_sets import with_known_parents
from mossar_adapters.source import Recording
from mossar_stream import Frames, constant_times, performer_name


def read(path: Path, options: ReadOptions) -> Recording:
    """Read the motion capture stream."""
    stream, notes = _choice(path, options)
    loaded = _loaded(path, stream)
    series = np.asarray(loaded["time_series"])
    if series.ndim != 2 or not len(series) or series.dtype.kind not in "fiu":
        raise FileError(path, f"the stream {shown(stream.name)} has no samples of numbers")
    headings, unit = channel_headings(loaded["info"], series.shape[1])
    columns = find_columns(headings) or unnamed_columns(path, series.shape[1])
    times, fps = _clock(path, loaded, options)
    name = performer_name(stream.name) if options.performer else "p1"
    order = [column for xyz in columns.xyz for column in xyz]

    def chunks() -> Iterator[Frames]:
        for start in range(0, len(series), CHUNK):
            with np.errstate(invalid="ignore"):  # damaged floats may be signalling NaN
                rows = series[start : start + CHUNK].astype(np.float64)
            confidence = rows[:, list(columns.confidence)] if columns.confidence else None
            positions = rows[:, order].reshape(len(rows), -1, 3)
            yield sane_frames(positions, times[start : start + CHUNK], confidence, name)

    parents, root = with_known_parents(columns.joints)
    skeleton = skeleton_of(path, columns.joints, parents, root)
    recording = Recording(str(path), skeleton, fps, chunks, notes, len(series), (name,))
    return in_stated_unit(recording, options, unit)


def _choice(path: Path, options: ReadOptions) -> tuple[Stream, tuple[str, ...]]:
    """Return the stream to read, and notes."""
    streams, cut = streams_of(path)
    fitting = [
        s for s in streams if "mocap" in "".join(c for c in s.type.lower() if c.isalpha()) and s.sample_size
    ]
    if not fitting:
        present = ", ".join(f"{s.name[:30]} ({s.type[:20]})" for s in streams[:8]) or "none"
        raise FileError(path, f"there is no stream of type MoCap; streams: {present}")
    wanted = [s for s in fitting if performer_name(s.name) == options.performer]
    stream = (wanted or fitting)[0]
    others = [s.name for s in fitting if s is not stream]
    notes = (f"other motion capture streams left out: {', '.join(others[:8])}",) if others else ()
    return stream, (*notes, "the file is cut off; its whole chunks are read") if cut else notes


def _loaded(path: Path, stream: Stream) -> dict[str, Any]:
    import pyxdf

    logging.getLogger(pyxdf.pyxdf.logger.name).setLevel(logging.CRITICAL)  # our own messages replace its
    data = checked_stream(path, stream)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            streams, _ = pyxdf.load_xdf(io.BytesIO(data), verbose=None)
        loaded: dict[str, Any] = streams[0]
    except Exception as error:  # noqa: BLE001 - the library raises whatever damage makes it stumble over
        raise FileError(path, f"the stream {shown(stream.name)} is damaged ({error!r})") from None
    return loaded


def channel_headings(info: dict[str, Any], count: int) -> tuple[list[str], str]:
    """Return a heading per channel, and the unit if all positions have the same.

    Args:
        info: The stream's description as pyxdf gives it: every element a list.
        count: Number of channels.
    """
    try:
        channels = info["desc"][0]["channels"][0]["channel"][:count]
    except (KeyError, IndexError, TypeError):
        return [""] * count, ""
    headings, units = [], set()
    for channel in channels:
        label, kind = (_text(channel, key) for key in ("label", "type"))
        thing = _text(channel, "marker") or _text(channel, "object") or label
        typed = re.fullmatch(r"position[\s_]?([xyz])", kind, re.IGNORECASE)
        headings.append(f"{thing}.{typed[1]}" if typed and thing else label)
        units.add(_text(channel, "unit").lower())
    if find_columns(headings) is None:
        headings = [_text(channel, "label") for channel in channels]
    return headings + [""] * (count - len(headings)), units.pop() if len(units) == 1 else ""


def _text(channel: Any, key: str) -> str:
    found = channel.get(key) if isinstance(channel, dict) else None
    return str(found[0]) if isinstance(found, list) and found and found[0] is not None else ""


def unnamed_columns(path: Path | str, count: int) -> Columns:
    """Return the columns of channels without labels: x y z of one joint after the other.

    Raises:
        FileError: If their number is not a multiple of three.
    """
    if count % 3:
        raise FileError(
            path, f"the {count} channels have no labels such as hip_x, and are not x y z of joints"
        )
    joints = count // 3
    return Columns(
        tuple(f"joint{i}" for i in range(joints)), tuple((3 * i, 3 * i + 1, 3 * i + 2) for i in range(joints))
    )


def _clock(
    path: Path, loaded: dict[str, Any], options: ReadOptions
) -> tuple[NDArray[np.float64], float | None]:
    times = np.asarray(loaded["time_stamps"], dtype=np.float64)
    if options.fps is not None:
        return constant_times(len(times), options.fps), options.fps
    if not np.isfinite(times).all():
        raise FileError(path, "a time stamp is not finite")
    try:
        nominal = float(loaded["info"]["nominal_srate"][0])
    except (KeyError, IndexError, TypeError, ValueError):
        nominal = 0.0
    return times, nominal if plausible_rate(nominal) else rate_of_times(times)
