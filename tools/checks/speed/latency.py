"""Latency: the time from sending a frame to receiving its event, in a client outside `mossar run`."""

from collections.abc import Iterator

from checks.delay import delays
from checks.load import RATES
from mossar_tools.bench.measurement import Measurement, Target
from mossar_tools.bench.work import Work

SECONDS = 20.0
_LABELS = ("p50", "p99", "longest")
_ADDED = {"p50": Target(1.0), "p99": Target(5.0)}


def measure(work: Work) -> Iterator[Measurement]:
    """Yield the delays over OSC and ZeroMQ, in and out, at 60 frames/s, and their excess over those of a plain echo."""
    for transport in RATES:
        work.on_progress(f"latency: {transport}")
        found = delays(transport, work.some(int(SECONDS), 3))
        note = f"{len(found.through)} messages; inside mossar run {found.inside_p50:.2f} and {found.inside_p99:.2f} ms"
        through, echoed = (dict(zip(_LABELS, values, strict=True)) for values in found.quantiles_ms())
        added = {label: through[label] - echoed[label] for label in _ADDED}
        for what, values in (("in and out", through), ("plain echo", echoed), ("added", added)):
            for label, value in values.items():
                target = _ADDED[label] if what == "added" else None
                name = f"{transport}, {what}: {label}"
                yield Measurement("latency", name, "ms", (value,), target=target, note=note, clock="wall")
                note = ""
