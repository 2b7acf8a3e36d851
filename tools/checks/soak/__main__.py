"""The program: `python -m checks.soak --minutes 10`."""

import argparse
import contextlib
import resource
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from checks.soak.measure import Sample, early_and_late, files, measure_exactly, memory, threads
from checks.soak.neighbours import Neighbours
from checks.soak.receivers import OscReceiver, Receiver, Subscriber
from checks.soak.stage import FPS, MAX_PAUSE, NAMES, Stage
from checks.soak.truth import Truth
from mossar_adapters.address import parse_url
from mossar_adapters.demo.body import SKELETON
from mossar_adapters.metrics import Metrics
from mossar_adapters.osc.event_sink import OscSink
from mossar_adapters.pipeline import Outcome, Pipeline, Upkeep
from mossar_adapters.replay.msk_sink import MskFrameSink
from mossar_adapters.sink import FrameSink, Sink
from mossar_adapters.source import Meta
from mossar_adapters.websocket import WebSocketSink
from mossar_adapters.zeromq.sink import ZmqSink
from mossar_adapters.zeromq.source import ZmqSource
from mossar_stream import Event, Settings

MOST_GROWTH = 4 << 20  # bytes
DISK = 16 << 20  # bytes that a file may have: the recording's disk is full after them
_PERIOD = 1.0  # s between two samples
_PATIENCE = 10.0  # s given to the last events
_LINE = 10  # samples between two lines


class Comparing:
    """A sink that compares events with the truth."""

    name = "comparison"
    dropped = 0

    def __init__(self, truth: Truth) -> None:
        self._truth = truth

    def announce(self, meta: Meta) -> None:
        """Do nothing: the events name their performer."""

    def send(self, events: Sequence[Event]) -> None:
        """Compare."""
        self._truth.check(events)

    def close(self) -> None:
        """Do nothing: there is nothing to release."""


class Watcher:
    """Measures while the pipeline runs, and ends it when the time is over.

    Args:
        stage: Is asked to end.
        truth: Knows which events are still to come.
        seconds: How long performers send.
    """

    def __init__(self, stage: Stage, truth: Truth, seconds: float) -> None:
        self.samples: list[Sample] = []
        self._stage, self._truth, self._seconds = stage, truth, seconds
        self._give_up = 0.0  # monotonic s, when events that have not come are lost
        self._started = self._looked = 0.0  # monotonic s; the strangers of the beginning come before

    def tick(self, pipeline: Pipeline) -> None:
        """Do the work that is due; called by the pipeline."""
        now = time.monotonic()
        if not self._stage.playing:
            self._give_up = self._give_up or now + _PATIENCE
            if not self._truth.missing or now > self._give_up:
                pipeline.stop()
        elif not self._started:
            if self._stage.performing.is_set():
                self._started = self._looked = now
        elif now - self._looked >= _PERIOD:
            self._looked = now
            self._measure(pipeline, now - self._started)
            if now - self._started > self._seconds:
                self._stage.stop()

    def _measure(self, pipeline: Pipeline, seconds: float) -> None:
        latencies = (pipeline.performers[name].latency for name in NAMES if name in pipeline.performers)
        known = [q for q in (late.quantiles_ms() for late in latencies) if q is not None]
        median, high = (max(q[0] for q in known), max(q[1] for q in known)) if known else (0.0, 0.0)
        sample = Sample(seconds, pipeline.outcome.frames, memory(), files(), threads(), median, high)
        self.samples.append(sample)
        if len(self.samples) % _LINE == 1:
            print(
                f"{seconds:6.0f} s {sample.frames:>9} frames {sample.memory / 2**20:7.1f} MB {sample.files:>3} files"
                f" {sample.threads:>3} threads, latency {median:.2f} ms median, {high:.2f} ms 99 %",
                flush=True,
            )


def main() -> int:
    """Run, print how it goes, and return 1 if events were lost or false, or something grew."""
    parser = argparse.ArgumentParser(
        prog="python -m checks.soak", description="Faults by the thousand; the events must be right."
    )
    parser.add_argument("--minutes", metavar="N", type=float, default=1.0)
    parser.add_argument(
        "--seed", metavar="S", type=int, default=1, help="the same seed makes the same faults"
    )
    given = parser.parse_args()
    measure_exactly()
    resource.setrlimit(resource.RLIMIT_FSIZE, (DISK, resource.RLIM_INFINITY))
    with tempfile.TemporaryDirectory() as folder:
        return soak(Path(folder), given.minutes * 60, given.seed)


def soak(folder: Path, seconds: float, seed: int) -> int:
    """Run for so many seconds and return the exit status."""
    settings = Settings(max_pause=MAX_PAUSE)
    truth = Truth(SKELETON, settings)
    source = ZmqSource(parse_url("zmq+bind://127.0.0.1:0"))
    stage = Stage(source.endpoint.replace("tcp:", "zmq:"), truth, lambda: pipeline.outcome.frames, seed)
    published, osc = ZmqSink(parse_url("zmq+bind://127.0.0.1:0")), OscReceiver(truth)
    recording = MskFrameSink(parse_url(str(folder / "take.msk")))
    receivers = (Subscriber(published.endpoint, truth), osc)
    sinks: list[Sink | FrameSink] = [Comparing(truth), published, recording]
    pages = WebSocketSink(parse_url("ws://127.0.0.1:0"))
    sinks += [OscSink(parse_url(f"osc://127.0.0.1:{osc.port}")), pages]
    watcher = Watcher(stage, truth, seconds)
    pipeline = Pipeline(
        [source],
        sinks,
        settings,
        upkeep=Upkeep(stats=5.0, snapshot=folder / "state"),
        tick=lambda: watcher.tick(pipeline),
    )
    with contextlib.closing(Metrics(pipeline, 0)) as metrics:
        neighbours = Neighbours(metrics.port, pages.port)
        for beginner in (*receivers, neighbours, stage):
            beginner.start()
        outcome = pipeline.run()
        for ender in (*receivers, neighbours):
            ender.stop()
    stage.close()
    stage.faults.injected.update(neighbours.counted)
    return _judge(stage, truth, watcher.samples, outcome, receivers, neighbours)


def _judge(
    stage: Stage,
    truth: Truth,
    samples: list[Sample],
    outcome: Outcome,
    receivers: Sequence[Receiver],
    neighbours: Neighbours,
) -> int:
    """Print the findings, and return the exit status."""
    hours = stage.sent / FPS / 3600
    print(f"{stage.sent} frames sent, {outcome.frames} taken: {hours:.1f} hours of motion at {FPS:.0f} Hz")
    print("faults: " + ", ".join(f"{count} {name}" for name, count in sorted(stage.faults.injected.items())))
    print(f"events: {truth.equal} as they must be, {truth.missing} lost, {truth.wrong} false")
    for receiver in receivers:
        print(f"{receiver.name}: died {receiver.lives} times, heard {receiver.heard} messages, all true")
    print(f"outputs that failed, as they should: {', '.join(outcome.dead_sinks) or 'none'}")
    early, late = early_and_late(samples)
    grown = late.memory - early.memory
    print(
        f"memory grew by {grown / 2**20:.2f} MB; files {early.files} to {late.files}, threads {early.threads} to"
        f" {late.threads}; latency, highest 99th percentile {max(s.high_ms for s in samples):.2f} ms"
    )
    failures = [
        (stage.error is not None, f"the stage failed: {stage.error}"),
        (stage.sent != outcome.frames, "frames were lost"),
        (truth.missing + truth.wrong > 0, "events were lost or false"),
        (any(receiver.heard == 0 for receiver in receivers), "a receiver heard nothing"),
        (bool(neighbours.faults), f"neighbours did harm: {', '.join(sorted(set(neighbours.faults)))}"),
        (grown > MOST_GROWTH, f"memory grew by more than {MOST_GROWTH >> 20} MB"),
        (late.files > early.files + 4 or late.threads > early.threads + 2, "handles or threads were left"),
    ]
    for failed, what in failures:
        if failed:
            print(f"FAILED: {what}", file=sys.stderr)
    for difference in truth.differences:
        print(difference, file=sys.stderr)
    return int(any(failed for failed, _ in failures))


if __name__ == "__main__":
    sys.exit(main())
