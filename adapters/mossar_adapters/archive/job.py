"""Job: the recordings of a place, spread over a Ray cluster or the cores of this machine."""

import logging
import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import msgspec

import mossar_stream
from mossar_adapters.archive.places import Place, is_recording
from mossar_adapters.archive.segmenting import problem, segment_file
from mossar_adapters.archive.tables import (
    add_rows,
    delete_unfinished,
    done_paths,
    no_rows,
    part_name,
    write_part,
)
from mossar_adapters.files import ReadOptions
from mossar_stream import MossarError, Moves, Settings

SMALLEST_PART, LARGEST_PART = 8, 256  # recordings
PARTS = 1000  # if there are that many recordings
STORE_BYTES = 256 << 20  # for data between workers: names and counts
RETRIES = 2  # of a part whose worker died
ORDER_FILE = "_order"  # no extension of a recording, and passed over by readers of Parquet


class Progress(msgspec.Struct):
    """Progress of a job.

    Args:
        recordings: Number of recordings.
        done: Read and segmented, by former runs too.
        broken: In the errors table, by former runs too.
        frames: Segmented by this run.
        passed_over: Files with other extensions.
    """

    recordings: int
    done: int = 0
    broken: int = 0
    frames: int = 0
    passed_over: int = 0


class Order(msgspec.Struct, frozen=True):
    """The shared settings of a job; written beside the tables, so that a job goes on as it began."""

    source: str
    settings: Settings
    reading: ReadOptions
    moves: str | None = None  # as a file of moves has them
    follow: tuple[str, ...] | bool = ()
    version: str = mossar_stream.__version__


def run(
    source: str,
    target: str,
    settings: Settings,
    reading: ReadOptions,
    moves: Moves | None = None,
    follow: tuple[str, ...] | bool = (),
    *,
    resume: bool,
    on_progress: Callable[[Progress], None],
) -> Progress:
    """Segment all recordings of a place into tables.

    Args:
        source: Folder or URL.
        target: Folder or URL, empty unless `resume`.
        settings: Settings of the segmenters.
        reading: Options of reading.
        moves: That are recognised.
        follow: Names of those that are followed, or True for all.
        resume: Whether to go on where a job was cut short.
        on_progress: Called now and then.

    Raises:
        MossarError: If the places cannot be used.
    """
    place = Place(target)
    files = _listed(source)
    where = source if "://" in source else str(Path(source).resolve())
    order = Order(where, settings, reading, None if moves is None else moves.to_json().decode(), follow)
    recordings = [path for path in files if is_recording(path)]
    if not recordings:
        raise MossarError(f"{source}: there is no recording in it; mossar adapters lists the formats")
    _begin(place, order, resume=resume)
    done = done_paths(place)
    broken = done_paths(place, ["errors"])
    progress = Progress(
        len(recordings), len(done - broken), len(broken), passed_over=len(files) - len(recordings)
    )
    on_progress(progress)
    pending = [path for path in recordings if path not in done]
    if pending:
        with_ray(lambda: _spread(pending, target, order, progress, on_progress))
    return progress


def segment_part(paths: Sequence[str], target: str, order: Order) -> dict[str, int]:
    """Segment some recordings and write their part of the tables.

    Args:
        paths: Relative to the source.
        target: Where the tables are.
        order: Everything else.

    Returns:
        How many were `done` and `broken`, and their `frames`.
    """
    rows, source, broken = no_rows(), Place(order.source), 0
    moves = None if order.moves is None else Moves.from_json(order.moves.encode())
    for path in paths:
        here = path
        try:
            with source.local(path) as file:
                here = str(file)
                found = segment_file(file, order.settings, order.reading, moves, order.follow)
        except Exception as error:  # noqa: BLE001 - one file must not stop the others, whatever is wrong with it
            rows["errors"].append({"path": path, "error": problem(error).replace(here, path)})
            broken += 1
        else:
            add_rows(rows, path, found)
    write_part(Place(target), part_name(paths), rows)
    frames = sum(row["frames"] for row in rows["recordings"])
    return {"done": len(paths) - broken, "broken": broken, "frames": frames}


def parts_of(paths: Sequence[str]) -> list[list[str]]:
    """Return the files in parts: few enough to be files of a good size, small enough to lose little of."""
    size = min(LARGEST_PART, max(SMALLEST_PART, len(paths) // PARTS))
    return [list(paths[at : at + size]) for at in range(0, len(paths), size)]


def with_ray(work: Callable[[], None]) -> None:
    """Do work with a Ray cluster: the one that RAY_ADDRESS names, else the cores of this machine."""
    # Ray's usage reports are off.
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    os.environ.setdefault("RAY_DATA_LOG_LEVEL", "ERROR")
    import ray

    if "RAY_ADDRESS" in os.environ:
        ray.init(logging_level=logging.ERROR)
    else:
        ray.init(
            "local",
            include_dashboard=False,
            logging_level=logging.ERROR,
            log_to_driver=False,
            object_store_memory=STORE_BYTES,
        )
    try:
        work()
    finally:
        ray.shutdown()


def _spread(
    pending: list[str], target: str, order: Order, progress: Progress, on_progress: Callable[[Progress], None]
) -> None:
    """Segment recordings; those whose worker died once more by themselves, and then they count as broken."""
    for parts in (parts_of(pending), None):
        if parts is None:
            done = done_paths(Place(target))
            parts = [[path] for path in pending if path not in done]
        for found in _rows(parts, target, order):
            progress.done += found["done"]
            progress.broken += found["broken"]
            progress.frames += found["frames"]
            on_progress(progress)
    done = done_paths(Place(target))
    lost = [path for path in pending if path not in done]
    if lost:
        rows = no_rows()
        rows["errors"] = [
            {"path": path, "error": f"{path}: the process that reads it ends, perhaps for lack of memory"}
            for path in lost
        ]
        write_part(Place(target), part_name(["lost", *lost]), rows)
        progress.broken += len(lost)
        on_progress(progress)


def _rows(parts: list[list[str]], target: str, order: Order) -> Iterator[dict[str, int]]:
    """Yield the result of `segment_part` for each part, in the order of completion."""
    if not parts:
        return
    import ray

    context = ray.data.DataContext.get_current()
    context.enable_progress_bars = False
    context.max_errored_blocks = -1
    items: list[dict[str, Any]] = [{"paths": part} for part in parts]
    data = ray.data.from_items(items, override_num_blocks=len(items))
    with warnings.catch_warnings():
        # Without a limit Ray repeats a task that kills its workers for ever; this is the only way to set one.
        warnings.simplefilter("ignore")
        mapped = data.map(_task, fn_args=(target, order), num_cpus=1, max_retries=RETRIES)
    yield from mapped.iter_rows()


def _task(row: dict[str, Any], target: str, order: Order) -> dict[str, int]:
    return segment_part(list(row["paths"]), target, order)


def _listed(source: str) -> list[str]:
    place = Place(source)
    if not place.exists():
        raise MossarError(f"{source}: there is no such folder")
    return place.paths()


def _begin(place: Place, order: Order, *, resume: bool) -> None:
    """Check that the tables are this job's, and delete incomplete parts.

    Raises:
        MossarError: If they are not, or there are some and `resume` is not given.
    """
    there = place.paths()
    if there and not resume:
        raise MossarError(f"{place.url}: it is not empty; --resume continues, or name another folder")
    if ORDER_FILE in there:
        with place.read(ORDER_FILE) as stream:
            before = stream.read()
        if before != msgspec.json.encode(order):
            raise MossarError(
                f"{place.url}: was begun with another version, source or settings (see {ORDER_FILE} in it); "
                "results of two kinds are not mixed: name another folder"
            )
    elif there:
        raise MossarError(
            f"{place.url}: holds other things than a job of mossar archive; name another folder"
        )
    else:
        with place.write(ORDER_FILE) as stream:
            stream.write(msgspec.json.encode(order))
    delete_unfinished(place)
