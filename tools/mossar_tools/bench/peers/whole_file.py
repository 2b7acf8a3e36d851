"""Whole file: a baseline that knows what no stream does, the whole recording and how many cuts it has."""

import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_tools.bench.peers.contest import Race, gathered
from mossar_tools.bench.peers.peer import samples
from mossar_tools.evaluation.found import Found
from mossar_tools.evaluation.takes import Take

NAME = "ruptures KernelCPD (rbf)"
KNOWS = "the whole recording and the number of cuts"
RATE = 15.0  # Hz to which frames are thinned out


def told_the_number(takes: Sequence[Take]) -> Race:
    """Return what ruptures' exact kernel search finds when it is told how many cuts there are."""
    return gathered(takes, [_search(take) for take in takes])


def _search(take: Take) -> tuple[Found, NDArray[np.float64], float]:
    from ruptures import KernelCPD

    poses = samples(take, "poses")
    cpu, began = time.process_time(), time.perf_counter()
    step = max(1, round(take.fps / RATE))
    found = KernelCPD(kernel="rbf", min_size=2).fit(poses[::step]).predict(n_bkps=len(take.cuts))
    wall, cpu = time.perf_counter() - began, time.process_time() - cpu
    cuts = [float(take.times[place * step]) for place in found[:-1]]
    return Found(cuts, seconds=wall), np.full(len(take.times), np.nan), cpu
