"""A camera for `mossar run webcam:` at real speed, and the cost of that run: for `python -m checks.webcam --live MINUTES`.

The camera is a pipe of JPEG pictures, written at a steady rate. The run is a process of its own. Its events are read
from its standard output: the delay of an event is from the grab of the picture that caused it to the reader of its line.
"""

import contextlib
import itertools
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Final

import cv2
import msgspec
import numpy as np

from mossar_adapters.pose.pictures import pictures

MOST: Final = 600  # pictures of a clip; they are played to and fro
WIDEST: Final = 1280  # pixels; larger pictures are made smaller
QUALITY: Final = 85  # of the JPEG pictures
_SAMPLES: Final = 10.0  # s between two looks at the process
_WARM: Final = 20.0  # s in which the networks fill their memory; not judged
_TICKS: Final = os.sysconf("SC_CLK_TCK") if hasattr(os, "sysconf") else 100
_MEGABYTE: Final = 1 << 20


class _Line(msgspec.Struct):
    """The needed fields of an event."""

    type: str
    status: str = ""
    decided_time: float = 0.0
    frames: int = 0


class Run(msgspec.Struct):
    """Results of a run.

    Args:
        delays: s, of each confirmed key frame, from the grab of its picture to the reader of the line.
        frames: That it segmented.
        samples: Monotonic s, processor time in s and resident bytes, every ten seconds after the start.
        loads: Programs that wanted a core, the mean of a minute, at the same times.
    """

    delays: list[float]
    frames: int
    samples: list[tuple[float, float, int]]
    loads: list[float]

    def __str__(self) -> str:
        """Return the figures, in three lines."""
        (began, used, _), (ended, spent, _) = self.samples[0], self.samples[-1]
        memory = [held / _MEGABYTE for _, _, held in self.samples]
        fifth = max(1, len(memory) // 5)
        early, late = (float(np.median(part)) for part in (memory[:fifth], memory[-fifth:]))
        p50, p95 = np.percentile(np.array(self.delays) * 1e3, [50, 95])
        return (
            f"live, {(ended - began) / 60:.1f} minutes: picture to `confirmed` {p50:.1f} ms p50, {p95:.1f} ms p95 "
            f"({len(self.delays)} key frames, {self.frames} frames), {(spent - used) / (ended - began):.2f} of a core\n"
            f"load of the machine: {np.median(self.loads):.1f} programs on {os.cpu_count()} cores (median)\n"
            f"memory: {early:.0f} MB in the first fifth, {late:.0f} MB in the last, at most {max(memory):.0f} MB"
        )


def live(path: Path, model: str, minutes: float, rate: float) -> Run:
    """Let `mossar run` see a clip through a camera at real speed.

    Args:
        path: Of the clip.
        model: Of `webcam:`.
        minutes: After those in which it starts.
        rate: Pictures per second.
    """
    coded = [_coded(picture) for picture, _ in itertools.islice(pictures(path), MOST)]
    with tempfile.TemporaryDirectory() as folder:
        camera = Path(folder) / "camera.mjpeg"
        os.mkfifo(camera)
        stop = threading.Event()
        writer = threading.Thread(target=_play, args=(camera, coded, rate, stop), daemon=True)
        writer.start()
        with _started(camera, model) as process:
            found = Run([], 0, [], [])
            reader = threading.Thread(target=_read, args=(process.stdout, found), daemon=True)
            reader.start()
            time.sleep(_WARM)
            del found.delays[:]
            until = time.monotonic() + 60 * minutes
            while time.monotonic() < until and process.poll() is None:
                found.samples.append(_sample(process.pid))
                found.loads.append(os.getloadavg()[0])
                time.sleep(_SAMPLES)
            found.samples.append(_sample(process.pid))
            delays = list(found.delays)  # key frames confirmed by the end of the take wait for no picture
            process.terminate()
            reader.join()
            stop.set()
    return Run(delays, found.frames, found.samples, found.loads)


def _coded(picture: np.ndarray) -> bytes:
    share = min(1.0, WIDEST / picture.shape[1])
    smaller = cv2.resize(picture, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    return cv2.imencode(".jpg", smaller, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()


def _play(camera: Path, coded: list[bytes], rate: float, stop: threading.Event) -> None:
    """Write pictures to and fro until the reader goes."""
    with contextlib.suppress(BrokenPipeError), camera.open("wb", buffering=0) as pipe:
        begin = time.monotonic()
        for k, picture in enumerate(itertools.cycle(coded + coded[-2:0:-1])):
            time.sleep(max(0.0, begin + k / rate - time.monotonic()))
            if stop.is_set():
                return
            pipe.write(picture)


@contextlib.contextmanager
def _started(camera: Path, model: str) -> Iterator[subprocess.Popen[bytes]]:
    # A real camera states its format; for a pipe OpenCV would first read 5 MB to detect it.
    surroundings = os.environ | {"OPENCV_FFMPEG_CAPTURE_OPTIONS": "probesize;32768|analyzeduration;0"}
    url = f"webcam:{camera}?model={model}"
    command = [sys.executable, "-m", "mossar_tools", "run", url, "--quiet", "--stats", "10"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, env=surroundings)  # noqa: S603
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def _read(lines: IO[bytes], found: Run) -> None:
    decoder = msgspec.json.Decoder(_Line)
    for line in lines:
        now = time.monotonic()
        event = decoder.decode(line)
        if event.type == "key_frame" and event.status == "confirmed":
            found.delays.append(now - event.decided_time)
        elif event.type == "stats":
            found.frames = event.frames


def _sample(process: int) -> tuple[float, float, int]:
    """Return the monotonic time, s, the processor time of a process, s, and its memory, bytes."""
    folder = Path("/proc") / str(process)
    fields = (folder / "stat").read_text(encoding="ascii").rpartition(")")[2].split()
    pages = int((folder / "statm").read_text(encoding="ascii").split()[1])
    return time.monotonic(), (int(fields[11]) + int(fields[12])) / _TICKS, pages * os.sysconf("SC_PAGE_SIZE")
