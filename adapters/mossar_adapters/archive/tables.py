"""Tables: the output of a job, part by part.

    recordings/   one row for each performer of each file that was read; its part is written last
    key_frames/   all key frames of Algorithm 2, with their strengths
    segments/     those at the level of the settings
    moves/        those that were recognised, if a file of moves was given
    followed/     performances of the moves that are followed that were done
    poses/        those that were held or entered, if the file of moves has poses
    repetitions/  repetitions of movements, with the setting `repetitions`
    steps/        feet that come down or leave the ground, with the setting `steps`
    errors/       files that could not be read, and why

A part is whole when its file in `recordings` is there; incomplete parts of a killed job are deleted before the next one
begins. Every file is thus in `recordings` or `errors` exactly once.
"""

import hashlib
from collections.abc import Iterable, Sequence
from pathlib import PurePosixPath
from typing import Any, get_type_hints

import msgspec
import pyarrow as pa
import pyarrow.parquet as pq

from mossar_adapters.archive.places import Place
from mossar_adapters.archive.segmenting import Segmented
from mossar_adapters.spans import Spanning, span
from mossar_stream import (
    BODY,
    FollowEvent,
    KeyFrame,
    MoveEvent,
    PoseEvent,
    RepetitionEvent,
    Segment,
    StepEvent,
)

LAST = "recordings"  # the table whose part makes the others count

# Columns that are not listed are words.
_TYPES: dict[Any, pa.DataType] = {
    int: pa.int64(),
    float: pa.float64(),
    float | None: pa.float64(),
    tuple[str, ...]: pa.list_(pa.string()),
    dict[str, float]: pa.map_(pa.string(), pa.float64()),
    dict[str, float] | None: pa.map_(pa.string(), pa.float64()),
}
# Columns that are no fields of an event.
_OWN = dict.fromkeys(("start_time", "end_time", "x", "y", "z"), float)


def _schema(record: type, columns: str) -> pa.Schema:
    """Return the columns of a table; their types are those of the record's fields."""
    hints = {**_OWN, **get_type_hints(record)}
    types = {name: _TYPES.get(hints.get(name, str), pa.string()) for name in columns.split()}
    return pa.schema(types | ({"joints": pa.int32()} if "joints" in types else {}))


SCHEMAS: dict[str, pa.Schema] = {
    "key_frames": _schema(KeyFrame, "path performer channel frame time kind velocity strength"),
    "segments": _schema(
        Segment,
        "path performer channel start_frame end_frame start_time end_time state active_joints similarity"
        " active_start active_end limb",
    ),
    "moves": _schema(MoveEvent, "path performer name start_time end_time score limb"),
    "poses": _schema(PoseEvent, "path performer name start_time end_time seconds deviation limbs joint"),
    "repetitions": _schema(
        RepetitionEvent, "path performer channel start_time end_time count total period amplitude joint"
    ),
    "steps": _schema(StepEvent, "path performer side status time x y z confidence"),
    "followed": _schema(
        FollowEvent,
        "path performer name start_time end_time count tempo deviation limbs joint range score",
    ),
    "errors": _schema(object, "path error"),
    "recordings": _schema(Segmented, "path performer fps joints frames seconds notes"),
}

Rows = dict[str, list[dict[str, Any]]]


def no_rows() -> Rows:
    """Return empty tables."""
    return {name: [] for name in SCHEMAS}


def add_rows(rows: Rows, path: str, found: Iterable[Segmented]) -> None:
    """Add the results of a file."""
    for one in found:
        who = {"path": path, "performer": one.performer}
        rows["recordings"].append(
            who | {name: getattr(one, name) for name in SCHEMAS["recordings"].names[2:]}
        )
        for channel, (keys, parts) in {BODY: (one.key_frames, one.segments), **one.limbs}.items():
            where = {**who, "channel": channel}
            rows["key_frames"] += [{**where, **msgspec.structs.asdict(key)} for key in keys]
            rows["segments"] += [{**where, **msgspec.structs.asdict(part)} for part in parts]
        # Columns are picked by the schema; the performer of these events is that of a single recording.
        for table, events in (
            ("moves", one.moves),
            ("repetitions", one.repetitions),
            ("followed", one.followed),
            ("poses", one.poses),
        ):
            rows[table] += [_row_of(event) | who for event in events]
        rows["steps"] += [
            {**msgspec.structs.asdict(event), **who, **dict(zip("xyz", event.position, strict=True))}
            for event in one.steps
        ]


def _row_of(event: Spanning) -> dict[str, Any]:
    """Return the fields of an event, maps as pairs, and when it began and ended."""
    fields = msgspec.structs.asdict(event)
    values = {name: [*value.items()] if isinstance(value, dict) else value for name, value in fields.items()}
    return values | dict(zip(("start_time", "end_time"), span(event), strict=True))


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
    """Delete incomplete parts of a killed job."""
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
