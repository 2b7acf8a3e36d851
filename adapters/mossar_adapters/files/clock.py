"""Times as tables write them, in seconds."""

import datetime as dt
import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

_SPAN = re.compile(r"(?:(\d{1,6})\s*days?\s*,?\s*)?(\d{1,4}):(\d{1,2}):(\d{1,2}(?:[.,]\d*)?)")
LONGEST = 64  # characters
# Dates in ticks of 100 ns, from about 1980 to 2100: since the year 1 (.NET) and since 1601 (Windows).
_TICKS = ((6.24e17, 6.63e17), (1.19e17, 1.58e17))
# Seconds per unit, its name, and the steps that are taken for it: below each, and not below the one before.
_USUAL_STEPS = (
    (1.0, "s", 2.0),
    (1e-3, "ms", 1500.0),
    (1e-6, "µs", 1.2e5),
    (1e-7, "100 ns", 1.5e6),
    (1e-9, "ns", 1.5e10),
)


def seconds(cell: str) -> float:
    """Return a time as a number: plain, `1 days 02:03:04.5`, `02:03:04.5` or an ISO date.

    Raises:
        ValueError: If it is none of these.

    Example:
        >>> seconds("0 days 00:00:40.129000000")
        40.129
    """
    cell = cell.strip().strip('"')[:LONGEST]
    try:
        return float(cell)
    except ValueError:
        pass
    if span := _SPAN.fullmatch(cell):
        days, hours, minutes = (int(part or 0) for part in span.groups()[:3])
        return days * 86400.0 + hours * 3600.0 + minutes * 60.0 + float(span[4].replace(",", "."))
    moment = dt.datetime.fromisoformat(cell)
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=dt.UTC)
    return moment.timestamp()


def unit_of_steps(times: Sequence[float] | NDArray[np.float64]) -> tuple[float, str]:
    """Return the unit of plain time stamps, judged by their steps: frames come 1 to 10000 times a second.

    Ticks of 100 ns are known as dates by their size, else at 7 to 83 Hz.

    Returns:
        Seconds per unit, and its name.

    Example:
        >>> unit_of_steps([0, 33, 67]), unit_of_steps([638_500_000_000_000_000, 638_500_000_000_333_333])
        ((0.001, 'ms'), (1e-07, '100 ns'))
    """
    given = np.asarray(times, dtype=np.float64)
    if len(given) and any(low < float(np.median(given)) < high for low, high in _TICKS):
        return 1e-7, "100 ns"
    steps = np.diff(given)
    steps = steps[np.isfinite(steps) & (steps > 0)]
    step = float(np.median(steps)) if len(steps) else 0.0
    if step < 1e-4:
        return 1.0, "s"
    return next(((unit, name) for unit, name, high in _USUAL_STEPS if step < high), (1.0, "s"))
