"""The counted repetitions at each time of a recording: the input of the rule in plain Python."""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import RANK, Channel, Performer, Workspace, at_once
from mossar_stream.core.plan import Plan
from mossar_stream.frames import constant_times
from mossar_stream.settings import Settings
from mossar_stream.skeleton import Skeleton

Array = NDArray[np.float64]


def counted_by(positions: Array, fps: float, skeleton: Skeleton) -> tuple[Array, list[Array]]:
    """Return the counted repetitions: the time of each analysis, s, and (n, 4) begin, end, period and number of each.

    The first three are in seconds; the number is that in its bout, from 1.

    Args:
        positions: (n, J, 3) m.
        fps: Hz.
        skeleton: Their joints.
    """
    plan = Plan(skeleton, Settings(), fps, offline=True)
    row = Channel(plan, "p1", plan.new_row())
    row.analyses = []
    core = Performer(Workspace(), (row,))
    core.process(np.array(positions, np.float32), constant_times(len(positions), fps))
    at_once([core], [(core.decide, RANK)])
    since, counted = zip(*row.analyses, strict=True)
    return np.array([0.0, *since]), [np.zeros((0, 4)), *map(_table, counted)]


def _table(headers: NDArray[np.void]) -> Array:
    """Return (n, 4) begin, end and period, s, and number in its bout, of the repetitions in a (1,) `Periods`."""
    header = headers[0]
    if not header["clear"]:
        return np.zeros((0, 4))
    cycles, origin = header["cycle"][: header["cycles"]], header["origin"]
    begins, ends, periods = (cycles[name] for name in ("begins", "ends", "period"))
    periods = np.where(np.isnan(periods), ends - begins, periods)
    table: Array = np.stack([origin + begins, origin + ends, periods, cycles["count"]], axis=1)
    return table
