"""Whole file: a baseline that knows more than any stream, the whole recording and its number of cuts."""

import time
from collections.abc import Sequence

import numpy as np

from checks.peers.feeds import PoseFeed
from checks.peers.runner import PeerRun, TakeRun, summed
from mossar_tools.evaluation.detection import Detection
from mossar_tools.evaluation.takes import Take

NAME = "ruptures KernelCPD (rbf)"
KNOWS = "the whole recording and the number of cuts"
RATE = 15.0  # Hz to which frames are thinned out


def told_the_number(takes: Sequence[Take]) -> PeerRun:
    """Return the cuts of ruptures' exact kernel search with the known number of cuts."""
    return summed(takes, [_search(take) for take in takes])


def _search(take: Take) -> TakeRun:
    from ruptures import KernelCPD

    feed = PoseFeed(take)
    cpu, began = time.process_time(), time.perf_counter()
    poses = np.array([feed.sample(own, 0.0) for own in take.positions], np.float64)
    ready = time.perf_counter()
    step = max(1, round(take.fps / RATE))
    found = KernelCPD(kernel="rbf", min_size=2).fit(poses[::step]).predict(n_bkps=len(take.cuts))
    ended, cpu = time.perf_counter(), time.process_time() - cpu
    cuts = [float(take.times[place * step]) for place in found[:-1]]
    return TakeRun(
        Detection(cuts, seconds=ended - began), ended - ready, cpu, np.full(len(take.times), np.nan)
    )
