"""What the tests of the Flink job share: performers, their records, and what a direct run says of them."""

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import time
from functools import partial
from itertools import zip_longest
from pathlib import Path

import msgspec
import numpy as np
import pytest
import zmq

from mossar_adapters.demo import DemoSource
from mossar_adapters.files import ReadOptions, open_recording
from mossar_adapters.flink.engine import latest_checkpoint
from mossar_adapters.flink.records import records_of
from mossar_adapters.source import Meta
from mossar_stream import Frames, Segmenter, Settings, to_json

ROOT = Path(__file__).parents[3]
LABELLED = ROOT.parent / "shared" / "data" / "labelled"


def environment():
    """Return the environment of a program that imports the project from here."""
    places = os.pathsep.join(str(ROOT / part) for part in ("", "adapters", "tools"))
    return {**os.environ, "PYTHONPATH": places}


def joined(name, chunks):
    """Return chunks as one, under a name."""
    confidence = None
    if chunks[0].confidence is not None:
        confidence = np.concatenate([chunk.confidence for chunk in chunks])
    positions = np.concatenate([chunk.positions for chunk in chunks])
    return Frames(positions, np.concatenate([chunk.times for chunk in chunks]), confidence, name)


def generated(count, seconds):
    """Return metas and frames of built-in performers."""
    people = []
    for seed in range(count):
        url = f"demo:?seed={seed}&seconds={seconds}&performer=g{seed}"
        meta, *chunks = DemoSource.from_url(url, speed="max").items()
        people.append((meta, joined(meta.performer, chunks)))
    return people


def labelled():
    """Return metas and frames of the labelled recordings, if they are here."""
    people = []
    for path in [*sorted(LABELLED.glob("*.amc")), *sorted(LABELLED.glob("precog/*.npz"))]:
        recording = open_recording(path, ReadOptions(skeleton=str(LABELLED / "86.asf")))
        frames = joined(path.stem, list(recording.chunks()))
        people.append((Meta(path.stem, recording.skeleton, recording.fps), frames))
    return people


def interleaved(people, size=10):
    """Return the lines of all performers' records in turns."""
    lines = [[*records_of(meta, text=True), *records_of(frames, size, text=True)] for meta, frames in people]
    return b"".join(line + b"\n" for turn in zip_longest(*lines) for line in turn if line is not None)


def direct(people, reason="end of stream"):
    """Return the lines that a segmenter by itself gives for each performer."""
    lines = {}
    for meta, frames in people:
        segmenter = Segmenter(meta.skeleton, Settings(), meta.performer, meta.fps)
        events = segmenter.push(frames) + segmenter.end_take(reason)
        lines[meta.performer] = [to_json(event) for event in events]
    return lines


def identity(line):
    """Return what tells an event from all others."""
    event = msgspec.json.decode(line)
    if event["type"] == "stream":
        return event["performer"], event["event"], event["take"]
    return event["id"], event.get("rev")


def by_performer(lines, *, repeats):
    """Return lines by performer, without repeats, which must be equal to what they repeat."""
    seen, found = {}, {}
    for line in lines:
        key = identity(line)
        if key in seen:
            assert repeats, f"{line!r} came twice"
            assert seen[key] == line
            continue
        seen[key] = line
        found.setdefault(json.loads(line)["performer"], []).append(line)
    return found


class Work:
    """A job in a folder, run as a process group of its own.

    Args:
        folder: Where everything lies.
        lines: The records.
        to: The table [to].
    """

    def __init__(self, folder, lines, to):
        self.folder = folder
        self.job = folder / "job.toml"
        self.out = folder / "out.jsonl"
        self.to = to
        self._started = []
        (folder / "records.jsonl").write_bytes(lines)

    def write(self, parallelism=1, source='files = "records.jsonl"', to=None):
        self.job.write_text(
            f"parallelism = {parallelism}\n[source]\n{source}\n[to]\n{to or self.to}\n"
            "[takes]\nidle = 60\n[checkpoints]\nseconds = 0.5\n"
        )

    def start(self, parallelism=1):
        self.write(parallelism)
        return self.launch()

    def launch(self):
        with self.out.open("ab") as out:
            process = subprocess.Popen(
                [sys.executable, "-m", "mossar_tools", "flink", str(self.job)],
                stdout=out,
                stderr=subprocess.PIPE,
                env=environment(),
                start_new_session=True,
            )
        self._started.append(process)
        return process

    def run(self, parallelism=1):
        process = self.start(parallelism)
        _, messages = process.communicate(timeout=600)
        assert process.returncode == 0, messages.decode()
        return messages.decode()

    def run_and_kill(self, share, expected):
        """Kill everything once a share of the expected events is out and a checkpoint is there."""
        process = self.start()
        until = time.monotonic() + 300
        while self.count() < share * expected or not self.checkpoints():
            assert process.poll() is None, process.stderr.read().decode()
            assert time.monotonic() < until, "the job makes no progress"
            time.sleep(0.02)
        self.kill(process)

    def kill(self, process):
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        process.stderr.close()

    def checkpoints(self):
        return list(self.folder.glob("checkpoints/*/chk-*/_metadata"))

    def latest_checkpoint(self):
        return latest_checkpoint((self.folder / "checkpoints").as_uri())

    def lines(self):
        """Return the whole lines that came out."""
        data = self.out.read_bytes()
        parts = self.folder.glob("events/*/events-*.jsonl")
        for part in sorted(parts, key=lambda path: path.stat().st_mtime_ns):
            data += part.read_bytes()
        return data[: data.rfind(b"\n") + 1].splitlines()

    def count(self):
        return len(self.lines())

    def clean_up(self):
        for process in self._started:
            if process.poll() is None:
                self.kill(process)


@pytest.fixture
def work(tmp_path):
    made = []

    def make(lines, to='live = "-"'):
        made.append(Work(tmp_path, lines, to))
        return made[-1]

    yield make
    for one in made:
        one.clean_up()


@pytest.fixture(scope="session")
def crowd():
    """200 built-in performers and the labelled recordings: their records, and what a direct run says."""
    people = generated(200, 15) + labelled()
    return interleaved(people), direct(people)


@pytest.fixture
def heard_live(tmp_path):
    """Run a job in this process between a socket and a subscriber, as long as the block lasts."""

    @contextlib.contextmanager
    def run(idle, forget):
        with contextlib.ExitStack() as opened:
            server = opened.enter_context(socket.create_server(("127.0.0.1", 0)))
            receiver = opened.enter_context(opened.enter_context(zmq.Context()).socket(zmq.SUB))
            receiver.setsockopt(zmq.SUBSCRIBE, b"mossar.stream.")
            port = receiver.bind_to_random_port("tcp://127.0.0.1")
            given = [server.getsockname()[1], port, idle, forget, tmp_path]
            program = [sys.executable, str(Path(__file__).with_name("live_job.py")), *map(str, given)]
            job = opened.enter_context(subprocess.Popen(program, env=environment()))
            opened.callback(job.kill)
            server.settimeout(60)
            wire, _ = server.accept()
            with wire:
                yield partial(_send, wire), partial(_hear, receiver)
            assert job.wait(60) == 0

    return run


def _send(wire, lines):
    wire.sendall(b"".join(line + b"\n" for line in lines))


PATIENCE = 120_000  # ms: with the first records Flink starts a worker


def _hear(receiver, until):
    """Return events up to one of a kind."""
    found = []
    while not found or found[-1]["event"] != until:
        assert receiver.poll(PATIENCE), f"only {found} came"
        found.append(json.loads(receiver.recv_multipart()[1]))
    return found


class Flink:
    """The functions above, for tests."""

    generated = staticmethod(generated)
    joined = staticmethod(joined)
    interleaved = staticmethod(interleaved)
    direct = staticmethod(direct)
    by_performer = staticmethod(by_performer)


@pytest.fixture(scope="session")
def flink():
    return Flink
