"""Limbs: the cost of key frames of five limbs, with their events, per frame, alone and with moves."""

from collections.abc import Iterator

from checks.speed.moves import EXAMPLES, JOINTS, examples_of
from checks.speed.turns import added, waits
from mossar_stream import Moves, Segmenter, Settings
from mossar_tools.bench.measurement import Measurement
from mossar_tools.bench.motion import performer
from mossar_tools.bench.work import Work


def measure(work: Work) -> Iterator[Measurement]:
    """Yield the mean time that limbs add to a push, its 99.9 % quantile, and the memory of a performer."""
    motion = performer(work.some(120, 8), joints=JOINTS)
    moves = examples_of(performer(120, joints=JOINTS, seed=2))

    def segmenter(*, limbs: bool, own: Moves | None) -> Segmenter:
        return Segmenter(motion.skeleton, Settings(limbs=limbs), fps=motion.fps, moves=own)

    for what, own in (("limbs", None), (f"limbs and {EXAMPLES} examples of moves", moves)):
        runs = []
        for _ in range(work.some(5, 1)):
            pair = segmenter(limbs=False, own=None), segmenter(limbs=True, own=own)
            runs.append(waits(motion, pair, work.some(50_000, 2000)))
        yield from added("limbs", f"{motion.name}, {JOINTS} joints, {what}", runs)
    plain, all_limbs = (segmenter(limbs=on, own=None).state_bytes for on in (False, True))
    yield Measurement("limbs", "memory of a performer's limbs", "kB", ((all_limbs - plain) / 1000,))
