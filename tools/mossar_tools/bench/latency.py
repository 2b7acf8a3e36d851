"""Latency: from sending a frame to receiving the event that it caused, by a client outside `mossar run`."""

from collections.abc import Iterator

import numpy as np

from mossar_tools.bench.measurement import Measurement
from mossar_tools.bench.work import Work
from mossar_tools.load import RATES, delays

SECONDS = 20.0


def measure(work: Work) -> Iterator[Measurement]:
    """Yield the delays over OSC and ZeroMQ, in and out, at 60 frames/s."""
    for transport in RATES:
        work.tell(f"latency: {transport}")
        found = delays(transport, work.some(int(SECONDS), 3))
        note = f"{len(found.seconds)} messages; inside mossar run {found.inside_p50:.2f} and {found.inside_p99:.2f} ms"
        for label, share in (("p50", 0.5), ("p99", 0.99), ("longest", 1.0)):
            value = float(np.quantile(found.seconds, share)) * 1e3
            name = f"{transport}, in and out: {label}"
            yield Measurement("latency", name, "ms", (value,), note=note, clock="wall")
            note = ""
