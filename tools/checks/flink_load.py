"""Measure `mossar flink` on this machine: `python -m checks.flink_load --performers 200 --seconds 60`.

Printed are the CPU time of a frame in the job and in a direct call, the size of a performer's state, and the delay
from a record handed to the engine until its events are out, at the pace of real performers.
"""

import argparse
import socket
import tempfile
import threading
import time
from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import zmq

from mossar_adapters.demo import DemoSource
from mossar_adapters.flink.job import Job, Source, Target
from mossar_adapters.flink.records import records_of
from mossar_adapters.source import Meta
from mossar_stream import Frames, Segmenter

FPS = 60.0  # of the built-in performer
WARM = 10.0  # s of motion after which delays count
_LEAVE = 3.0  # s for the last events to arrive


def main() -> None:
    """Measure, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--performers", type=int, default=200)
    parser.add_argument("--seconds", type=float, default=60.0, help="of each performer")
    parser.add_argument("--size", type=int, default=10, help="frames in a record")
    parser.add_argument("--paced", type=int, default=50, help="performers while delays are measured")
    given = parser.parse_args()
    people = [_performer(seed, given.seconds) for seed in range(given.performers)]
    frames = sum(len(chunk) for _, chunk in people)
    alone, state = _direct(people, given.size)
    print(
        f"direct call, {given.size} frames at a time: {1e6 * alone / frames:.1f} µs a frame; "
        f"{state} bytes of state a performer"
    )
    lines = [_lines(meta, chunk, given.size) for meta, chunk in people]
    with tempfile.TemporaryDirectory() as folder:
        used = _job(Path(folder), lines)
        print(
            f"Flink, {given.size} frames a record: {1e6 * used / frames:.1f} µs of CPU a frame, "
            f"{frames / used:.0f} frames/s a core, {frames / used / FPS:.0f} performers a core"
        )
        delays = _delays(Path(folder), lines[: given.paced], given.size)
    p50, p99 = np.percentile(delays, [50, 99]) * 1000
    rate = min(given.paced, given.performers) * FPS
    print(
        f"record to event at {rate:.0f} frames/s: p50 {p50:.1f} ms, p99 {p99:.1f} ms ({len(delays)} events)"
    )


def _performer(seed: int, seconds: float) -> tuple[Meta, Frames]:
    url = f"demo:?seed={seed}&seconds={seconds}&performer=g{seed}"
    items = list(DemoSource.from_url(url, speed="max").items())
    meta = next(item for item in items if isinstance(item, Meta))
    chunks = [item for item in items if isinstance(item, Frames)]
    positions = np.concatenate([chunk.positions for chunk in chunks])
    times = np.concatenate([chunk.times for chunk in chunks])
    return meta, Frames(positions, times, None, meta.performer)


def _lines(meta: Meta, frames: Frames, size: int) -> list[bytes]:
    return [*records_of(meta, text=True), *records_of(frames, size, text=True)]


def _direct(people: list[tuple[Meta, Frames]], size: int) -> tuple[float, int]:
    """Return the CPU time of pushing all frames (s) and the size of a state (bytes)."""
    segmenters = [Segmenter(meta.skeleton, None, meta.performer, meta.fps) for meta, _ in people]
    longest = max(len(frames) for _, frames in people)
    began = time.process_time()
    for at in range(0, longest, size):
        for segmenter, (_, frames) in zip(segmenters, people, strict=True):
            segmenter.push(frames.positions[at : at + size], frames.times[at : at + size])
    return time.process_time() - began, len(segmenters[0].snapshot())


def _job(folder: Path, lines: list[list[bytes]]) -> float:
    """Return the CPU time of the job over all records, s, without the time before the first one."""
    turns = [line + b"\n" for turn in zip_longest(*lines) for line in turn if line is not None]
    (folder / "records.jsonl").write_bytes(b"".join(turns))
    (folder / "few.jsonl").write_bytes(b"".join(turns[: len(turns) // 10]))
    jobs = {
        name: Job(source=Source(files=(folder / f"{name}.jsonl").as_uri()), to=_files(folder))
        for name in ("records", "few")
    }
    _used(jobs["records"], folder)  # warms up
    few, whole = _used(jobs["few"], folder), _used(jobs["records"], folder)
    # Both begin and end alike: they differ by nine tenths of the frames.
    return (whole - few) / 0.9


def _files(folder: Path) -> Target:
    return Target(files=(folder / "events").as_uri())


def _used(job: Job, folder: Path) -> float:
    env = _environment(job, folder)
    from mossar_adapters.flink.engine import build

    build(env, job)
    before = _cpu_time()
    env.execute(job.name)
    return _cpu_time() - before


def _environment(job: Job, folder: Path) -> Any:
    from pyflink.common import Configuration
    from pyflink.datastream import StreamExecutionEnvironment

    from mossar_adapters.flink.engine import options

    configuration = Configuration()
    chosen = {
        **options(job),
        "execution.checkpointing.dir": (folder / "checkpoints").as_uri(),
        "restart-strategy.type": "none",
    }
    for name, value in chosen.items():
        configuration.set_string(name, value)
    return StreamExecutionEnvironment.get_execution_environment(configuration)


def _cpu_time() -> float:
    """Return the CPU time that the engine's process has used, s."""
    from pyflink.java_gateway import get_gateway

    handle = get_gateway().jvm.java.lang.ProcessHandle.current()
    return float(handle.info().totalCpuDuration().get().toNanos()) / 1e9


def _delays(folder: Path, lines: list[list[bytes]], size: int) -> list[float]:
    """Return the delays of key frame events, s, while records come at the pace of real performers."""
    from pyflink.datastream import DataStream

    from mossar_adapters.flink.engine import build

    with socket.create_server(("127.0.0.1", 0)) as server, zmq.Context() as context:
        receiver = context.socket(zmq.SUB)
        receiver.setsockopt(zmq.SUBSCRIBE, b"")
        port = receiver.bind_to_random_port("tcp://127.0.0.1")
        job = Job(source=Source(files="-"), to=Target(live=f"zmq://127.0.0.1:{port}"))
        env = _environment(job, folder)
        host, number = server.getsockname()
        # No source of `mossar flink`: messages on the wire when the engine fails cannot be read again.
        socket_stream = env._j_stream_execution_environment.socketTextStream(host, number)  # noqa: SLF001
        build(env, job, DataStream(socket_stream))
        sent: dict[tuple[str, int], float] = {}
        sender = threading.Thread(target=_send, args=(server, lines, size, sent), daemon=True)
        sender.start()
        running = threading.Thread(target=env.execute, args=(job.name,), daemon=True)
        running.start()
        # Events that the end of the stream decides wait for the job to end.
        counted = range(round(WARM * FPS / size), len(lines[0]) - 2)
        delays = list(_received(receiver, sent, size, counted, running))
        receiver.close()
    return delays


def _send(
    server: socket.socket, lines: list[list[bytes]], size: int, sent: dict[tuple[str, int], float]
) -> None:
    """Send records, the performers' evenly spread over the time of a record."""
    wire, _ = server.accept()
    wire.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    period = size / FPS
    began = time.monotonic()
    with wire:
        for number in range(len(lines[0])):
            for who, performer in enumerate(lines):
                due = began + (number + who / len(lines)) * period
                time.sleep(max(0.0, due - time.monotonic()))
                sent[f"g{who}", number - 1] = time.monotonic()
                wire.sendall(performer[number] + b"\n")


def _received(
    receiver: Any, sent: dict[tuple[str, int], float], size: int, counted: range, running: threading.Thread
) -> Iterator[float]:
    """Yield the delays of key frame events that these records caused, s, until the job is over."""
    until = float("inf")
    while time.monotonic() < until:
        if not running.is_alive() and until == float("inf"):
            until = time.monotonic() + _LEAVE
        if not receiver.poll(100):
            continue
        _, data = receiver.recv_multipart()
        now, event = time.monotonic(), msgspec.msgpack.decode(data)
        if event["type"] == "key_frame" and (record := event["decided_frame"] // size) in counted:
            yield now - sent[event["performer"], record]


if __name__ == "__main__":
    main()
