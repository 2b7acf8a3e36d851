"""Targets that read files: recordings of every format."""

import contextlib
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from checks.fuzz.recordings import ASF, WRITERS, amc
from checks.fuzz.target import Feed, Target
from mossar_adapters.files import ReadOptions, open_recording
from mossar_adapters.files.registry import format_of
from mossar_stream import MossarError

FRAMES = 3  # of a sample; small files are read often
_LARGEST = 1 << 18  # bytes of a recording that is taken as a sample
_SHARES = {"msk": 3.0, "jsonl": 2.0, "csv": 2.0}  # of all inputs; 1 for the others
_OPTIONS = ReadOptions(allow_2d=True)


def file_targets(folder: Path | None = None) -> list[Target]:
    """Return one target per format, and one for the skeleton of AMC files.

    Args:
        folder: Its recordings are samples, too.
    """
    more = _recordings_in(folder) if folder else {}
    targets = []
    for kind, (name, write) in WRITERS.items():
        samples = [write() if kind == "openpose" else write(FRAMES)]
        if kind == "c3d":
            samples += [
                write(FRAMES, machine, integer=integer) for machine in (85, 86) for integer in (False, True)
            ]
        with _placed(name, samples[0]) as path:
            samples += more.get(format_of(path).name, [])
        targets.append(Target(f"file {kind}", _SHARES.get(kind, 1.0), _opener(name), samples))
    targets.append(Target("file asf", 1.0, _opener("a.asf", opened="a.amc"), [ASF]))
    return targets


def _recordings_in(folder: Path) -> dict[str, list[bytes]]:
    """Return the content of the small recordings below a folder, by format."""
    found: dict[str, list[bytes]] = {}
    for path in sorted(folder.rglob("*")):
        with contextlib.suppress(MossarError):
            if path.is_file() and path.stat().st_size <= _LARGEST:
                found.setdefault(format_of(path).name, []).append(path.read_bytes())
    return found


@contextlib.contextmanager
def scratch() -> Iterator[Path]:
    """Give a folder in memory, where there is one: files are written by the thousand."""
    memory = Path("/dev/shm")  # noqa: S108 - a folder of our own is made in it
    with tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None) as folder:
        yield Path(folder)


@contextlib.contextmanager
def _placed(name: str, content: bytes) -> Iterator[Path]:
    with scratch() as folder:
        path = folder / name
        path.write_bytes(content)
        yield path


def _opener(name: str, opened: str = "") -> Callable[[], contextlib.AbstractContextManager[Feed]]:
    @contextlib.contextmanager
    def begin() -> Iterator[Feed]:
        with scratch() as folder:
            (folder / "a.amc").write_bytes(amc(FRAMES))
            (folder / "a.asf").write_bytes(ASF)
            path, read = folder / name, folder / (opened or name)

            def feed(data: bytes) -> None:
                path.write_bytes(data)
                check_recording(read)

            yield feed

    return begin


def check_recording(path: Path) -> None:
    """Read a recording to its end, and check the promises of every reader.

    Raises:
        FileError: If it cannot be read.
        AssertionError: If a promise is broken.
    """
    recording = open_recording(path, _OPTIONS)
    count = 0
    for frames in recording.chunks():
        count += len(frames)
        _hold(frames.positions.dtype in (np.float32, np.float64), "positions are numbers")
        shape = (len(frames.times), len(recording.skeleton), 3)
        _hold(frames.positions.shape == shape, f"positions have the shape {shape}")
        _hold(bool(np.isfinite(frames.times).all()), "times are finite")
        _hold(not np.isinf(frames.positions).any(), "positions are finite or NaN")
        _hold(frames.performer in recording.performers, "the performer was announced")
    _hold(count > 0 and recording.frame_count in {None, count}, "the number of frames is the one announced")
    _hold(recording.fps is None or 0 < recording.fps <= 1e6, "the rate is possible")


def _hold(true: bool, promise: str) -> None:
    if not true:
        raise AssertionError(f"broken: {promise}")
