"""Tables: what a job writes, part by part.

    recordings/   one row for each performer of each file that was read; its part is written last
    key_frames/   all key frames of Algorithm 2, with their strengths
    segments/     those at the level of the settings
    moves/        those that were recognised, if a file of moves was given
    followed/     performances of the moves that are followed that were done
    repetitions/  repetitions of movements, with the setting `repetitions`
    steps/        feet that come down or leave the ground, with the setting `steps`
    errors/       files that could not be read, and why

A part is whole when its file in `recordings` is there; what a killed job left of others is deleted before the next one
begins. So every file stands in `recordings` or `errors` exactly once.
"""

import hashlib
from collections.abc import Iterable, Sequence
from pathlib import PurePosixPath
from typing import Any

import msgspec
import pyarrow as pa
import pyarrow.parquet as pq

from mossar_adapters.archive.places import Place
from mossar_adapters.archive.segmenting import Segmented
from mossar_stream import BODY

LAST = "recordings"  # the table whose part makes the others count

_FILE = [("path", pa.string())]
_WHO = [*_FILE, ("performer", pa.string())]
_CHANNEL = [("channel", pa.string())]  # body, or the limb (setting `limbs`)
_SPAN = [("start_time", pa.float64()), ("end_time", pa.float64())]
SCHEMAS: dict[str, pa.Schema] = {
    "key_frames": pa.schema(
        [
            *_WHO,
            *_CHANNEL,
            ("frame", pa.int64()),
            ("time", pa.float64()),
            ("kind", pa.string()),
            ("velocity", pa.float64()),
            ("strength", pa.float64()),
        ]
    ),
    "segments": pa.schema(
        [
            *_WHO,
            *_CHANNEL,
            ("start_frame", pa.int64()),
            ("end_frame", pa.int64()),
            *_SPAN,
            ("state", pa.string()),
            ("active_joints", pa.list_(pa.string())),
            ("similarity", pa.float64()),
            ("active_start", pa.float64()),
            ("active_end", pa.float64()),
            ("limb", pa.string()),
        ]
    ),
    "moves": pa.schema(
        [*_WHO, ("name", pa.string()), *_SPAN, ("score", pa.float64()), ("limb", pa.string())]
    ),
    "repetitions": pa.schema(
        [
            *_WHO,
            *_CHANNEL,
            *_SPAN,
            ("count", pa.int64()),
            ("total", pa.int64()),
            ("period", pa.float64()),
            ("amplitude", pa.float64()),
            ("joint", pa.string()),
        ]
    ),
    "steps": pa.schema(
        [
            *_WHO,
            ("side", pa.string()),
            ("status", pa.string()),
            ("time", pa.float64()),
            ("x", pa.float64()),
            ("y", pa.float64()),
            ("z", pa.float64()),
            ("confidence", pa.float64()),
        ]
    ),
    "followed": pa.schema(
        [
            *_WHO,
            ("name", pa.string()),
            *_SPAN,
            ("count", pa.int64()),
            ("tempo", pa.float64()),
            ("deviation", pa.float64()),
            ("limbs", pa.map_(pa.string(), pa.float64())),
            ("joint", pa.string()),
            ("range", pa.map_(pa.string(), pa.float64())),
            ("score", pa.float64()),
        ]
    ),
    "errors": pa.schema([*_FILE, ("error", pa.string())]),
    "recordings": pa.schema(
        [
            *_WHO,
            ("fps", pa.float64()),
            ("joints", pa.int32()),
            ("frames", pa.int64()),
            ("seconds", pa.float64()),
            ("notes", pa.list_(pa.string())),
        ]
    ),
}

Rows = dict[str, list[dict[str, Any]]]


def no_rows() -> Rows:
    """Return empty tables."""
    return {name: [] for name in SCHEMAS}


def add_rows(rows: Rows, path: str, found: Iterable[Segmented]) -> None:
    """Add what was found in a file."""
    for one in found:
        who = {"path": path, "performer": one.performer}
        rows["recordings"].append(
            {
                **who,
                "fps": one.fps,
                "joints": one.joints,
                "frames": one.frames,
                "seconds": one.seconds,
                "notes": one.notes,
            }
        )
        for channel, (keys, parts) in {BODY: (one.key_frames, one.segments), **one.limbs}.items():
            where = {**who, "channel": channel}
            rows["key_frames"] += [{**where, **msgspec.structs.asdict(key)} for key in keys]
            rows["segments"] += [{**where, **msgspec.structs.asdict(part)} for part in parts]
        # Columns are picked by the schema; the performer of these events is that of a single recording.
        for table, events in (("moves", one.moves), ("repetitions", one.repetitions)):
            rows[table] += [
                {**msgspec.structs.asdict(event), **who, "start_time": event.start, "end_time": event.end}
                for event in events
            ]
        rows["steps"] += [
            {**msgspec.structs.asdict(event), **who, **dict(zip("xyz", event.position, strict=True))}
            for event in one.steps
        ]
        rows["followed"] += [
            {**msgspec.structs.asdict(event), **who, "start_time": event.start, "end_time": event.time}
            | {name: list(getattr(event, name).items()) for name in ("limbs", "range")}
            for event in one.followed
        ]


def part_name(paths: Iterable[str]) -> str:
    """Return the name of the part that holds these files."""
    return f"part-{hashlib.sha256(chr(0).join(paths).encode()).hexdigest()[:16]}.parquet"


def write_part(place: Place, name: str, rows: Rows) -> None:
    """Write a part of all tables; the one that makes it count comes last."""
    for table in sorted(SCHEMAS, key=lambda table: table == LAST):
        if rows[table] or table == LAST:
            with place.write(f"{table}/{name}") as stream:
                pq.write_table(pa.Table.from_pylist(rows[table], SCHEMAS[table]), stream)


def delete_unfinished(place: Place) -> None:
    """Delete what a killed job left of parts that do not count."""
    files = {table: place.paths(table) for table in SCHEMAS}
    whole = {PurePosixPath(path).name for path in files[LAST]}
    for path in [path for paths in files.values() for path in paths]:
        if PurePosixPath(path).name not in whole or PurePosixPath(path).name.startswith("."):
            place.delete(path)


def done_paths(place: Place, tables: Sequence[str] = (LAST, "errors")) -> set[str]:
    """Return the files that stand in these tables."""
    done: set[str] = set()
    for table in tables:
        for path in place.paths(table):
            with place.read(path) as stream:
                done.update(pq.read_table(stream, columns=["path"]).column("path").to_pylist())
    return done
