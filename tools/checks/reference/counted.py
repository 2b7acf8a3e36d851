"""The counted repetitions at each time of a recording: the input of the rule in plain Python."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import RANK, Channel, Performer, Workspace, at_once
from mossar_stream.core.plan import Plan
from mossar_stream.frames import constant_times
from mossar_stream.settings import Settings
from mossar_stream.skeleton import Skeleton

Array = NDArray[np.float64]


class Counted(NamedTuple):
    """The counted repetitions at each time of a recording.

    Args:
        since: s, the time of each analysis.
        tables: (k, 4) begin, end and period, s, of each repetition, and its number in its bout, from 1.
        ways: (n, 3) s, after each frame: when the latest way out and back began and ended, and when the next one began; inf if not.
    """

    since: Array
    tables: list[Array]
    ways: Array


def counted_by(positions: Array, fps: float, skeleton: Skeleton) -> Counted:
    """Return the counted repetitions.

    Args:
        positions: (n, J, 3) m.
        fps: Hz.
        skeleton: Their joints.
    """
    plan = Plan(skeleton, Settings(), fps, offline=True)
    row = Channel(plan, "p1", plan.new_row())
    row.analyses = []
    core = Performer(Workspace(), (row,))
    frames, times = np.array(positions, np.float32), constant_times(len(positions), fps)
    ways = np.empty((len(frames), 3))
    for i in range(len(frames)):
        core.process(frames[i : i + 1], times[i : i + 1])
        way = row.state["ways"]
        ways[i] = way["begins"], way["ends"], way["leaves"]
    at_once([core], [(core.decide, RANK)])
    since, counted = zip(*row.analyses, strict=True)
    return Counted(np.array([0.0, *since]), [np.zeros((0, 4)), *map(_table, counted)], ways)


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
