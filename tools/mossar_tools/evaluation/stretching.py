"""Stretching: the same recordings with slower or quicker performers."""

from collections.abc import Callable, Iterator, Mapping, Sequence

import msgspec
import numpy as np

from mossar_stream import Settings
from mossar_tools.evaluation.matching import Cut
from mossar_tools.evaluation.metrics import median
from mossar_tools.evaluation.sets import set_methods
from mossar_tools.evaluation.takes import Take
from mossar_tools.evaluation.trial import Row, trial

NOTE = (
    "F1 of the final key frames, mean over recordings (key frames per true cut, median delay from the cut); x2: half as fast, "
    "frames on straight lines between those recorded, with twice the tolerance"
)


def stretched(take: Take, factor: float) -> Take:
    """Return a take that lasts `factor` times as long at the same rate, with its cuts and their tolerance.

    New frames are linear interpolations; a joint that is missing in one of two frames is missing between them.
    """
    if factor == 1.0:
        return take
    begin = float(take.times[0])
    times = begin + np.arange(int(take.duration * factor * take.fps + 1e-6) + 1) / take.fps
    places = np.interp((times - begin) / factor, take.times - begin, np.arange(len(take.times)))
    before = np.minimum(places.astype(np.int64), len(take.times) - 2)
    share = (places - before).astype(np.float32)[:, None, None]
    one, other = take.positions[before], take.positions[before + 1]
    between = np.where(share < 1.0, one + share * (other - one), other)
    cuts = [
        Cut(*(begin + factor * (time - begin) for time in msgspec.structs.astuple(cut))) for cut in take.cuts
    ]
    return msgspec.structs.replace(
        take,
        positions=np.where(share > 0.0, between, one),
        times=times,
        cuts=cuts,
        tolerance=factor * take.tolerance,
    )


def stretched_sets(sets: Mapping[str, Sequence[Take]], factors: Sequence[float]) -> dict[str, list[Take]]:
    """Return the takes of each set at each factor, by a name made of both."""
    return {
        named(name, factor): [stretched(take, factor) for take in takes]
        for name, takes in sets.items()
        for factor in factors
    }


def named(name: str, factor: float) -> str:
    """Return the name of a stretched set."""
    return f"{name} x{factor:g}"


def score_stretched(
    sets: Mapping[str, Sequence[Take]], settings: Settings, on_progress: Callable[[str], None]
) -> dict[str, list[Row]]:
    """Return the scores of a stream's final key frames on each set."""
    final = set_methods(settings)[:1]

    def score(name: str, takes: Sequence[Take]) -> list[Row]:
        return trial(takes, final, lambda text: on_progress(f"{name}: {text}"))

    return {name: score(name, takes) for name, takes in sets.items()}


def stretching_table(
    names: Sequence[str], factors: Sequence[float], rows: Mapping[str, Sequence[Row]]
) -> Iterator[str]:
    """Yield the lines of a table: a line for each set, a column for each factor, and the mean of the sets.

    Args:
        names: Of the sets.
        factors: Factors of the takes' durations.
        rows: By `named`.
    """
    yield f"{'':<24}" + "".join(f"{f'x{factor:g}':>24}" for factor in factors)
    for name in names:
        means = [rows[named(name, factor)][0].mean for factor in factors]
        cells = [f"{one.f1:.3f} ({one.key_frames:.2f}, {median(one.delays):.2f} s)" for one in means]
        yield f"{name[:23]:<24}" + "".join(f"{cell:>24}" for cell in cells)
    if len(names) > 1:
        f1 = [float(np.mean([rows[named(name, factor)][0].mean.f1 for name in names])) for factor in factors]
        yield f"{'mean':<24}" + "".join(f"{mean:>7.3f}{'':17}" for mean in f1).rstrip()
    yield ""
    yield NOTE
