"""Repetitions: the cost of counting them, per frame."""

from collections.abc import Iterator

from checks.speed.turns import added, waits
from mossar_stream import Segmenter, Settings
from mossar_tools.bench.measurement import Measurement
from mossar_tools.bench.motion import performer
from mossar_tools.bench.work import Work

JOINTS = 21
MORE = 1.5  # µs that a frame may take longer on average


def measure(work: Work) -> Iterator[Measurement]:
    """Yield the mean time that counting repetitions adds to a push, and the duration of a push with an analysis."""
    motion = performer(work.some(120, 8), joints=JOINTS)
    runs = []
    for _ in range(work.some(5, 1)):
        pair = [Segmenter(motion.skeleton, Settings(repetitions=on), fps=motion.fps) for on in (False, True)]
        runs.append(waits(motion, pair, work.some(50_000, 2000)))
    yield from added("repetitions", f"{motion.name}, {JOINTS} joints at {motion.fps:g} Hz", runs, MORE)
