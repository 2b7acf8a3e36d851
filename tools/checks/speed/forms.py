"""Forms: the duration of a push of frames in other forms than contiguous float32."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from mossar_tools.bench.measurement import Measurement, Target
from mossar_tools.bench.motion import Motion
from mossar_tools.bench.push import Form, waits
from mossar_tools.bench.work import Work

MORE = 1.0  # µs that another form of array may take longer

# Forms that callers pass instead of contiguous float32 and a Python float.
FORMS: Final[dict[str, Form]] = {
    "float64 positions": lambda frame, moment: (frame.astype(np.float64), moment),
    "numpy scalar as time": lambda frame, moment: (frame, np.float64(moment)),
    "float64 and numpy scalar": lambda frame, moment: (frame.astype(np.float64), np.float64(moment)),
    "view that is not contiguous": lambda frame, moment: (np.asfortranarray(frame), moment),
}
LISTS: Final[dict[str, Form]] = {
    "lists of lists": lambda frame, moment: (frame.tolist(), moment),
}


def measure(work: Work) -> Iterator[Measurement]:
    """Yield medians for other forms of frames."""
    yield from forms(work.motions[0], work.some(100_000, 500), work.some(3, 1))


def forms(motion: Motion, frames: int, repeats: int) -> Iterator[Measurement]:
    """Yield the median for each form of frames; arrays have a target relative to contiguous float32."""
    every: dict[str, Form | None] = {"": None, **FORMS, **LISTS}
    runs: dict[str, list[float]] = {name: [] for name in every}
    for _ in range(repeats):  # in turn, so that other processes disturb all forms alike
        for name, form in every.items():
            runs[name].append(float(np.median(waits(motion, frames, form)[0])) * 1e6)
    own = float(np.median(runs.pop("")))
    for name, values in runs.items():
        target = Target(own + MORE) if name in FORMS else None
        note = f"float32 and float: {own:.2f}"
        yield Measurement(
            "forms", f"{name}: p50", "us", tuple(values), target=target, note=note, clock="wall"
        )
