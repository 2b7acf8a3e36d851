"""Contest: a detector over takes, frame by frame, with a stopwatch."""

import time
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_tools.bench.peers.peer import Detector, Parameters, Peer, samples
from mossar_tools.evaluation.found import Found
from mossar_tools.evaluation.metrics import Scores, mean_scores
from mossar_tools.evaluation.takes import Take

Feeds = Mapping[str, NDArray[Any]]


class Race(msgspec.Struct, frozen=True):
    """What came of one way to find cuts on the takes of one level.

    Args:
        frames: Of all takes.
        wall: s that all updates took.
        cpu: s of processor time of the same.
        waits: s, of each update.
        scores: Mean over the takes.
    """

    frames: int
    wall: float
    cpu: float
    waits: NDArray[np.float64]
    scores: Scores


def feeds(takes: Sequence[Take], peer: Peer) -> dict[str, NDArray[Any]]:
    """Return what a peer is fed, by take."""
    return {take.name: samples(take, peer.feed) for take in takes}


def race(takes: Sequence[Take], peer: Peer, parameters: Parameters, fed: Feeds) -> Race:
    """Let a peer find the cuts of all takes.

    Args:
        takes: Of one level.
        peer: The peer.
        parameters: Of its detector.
        fed: As `feeds` returns them.
    """
    return gathered(
        takes, [followed(peer.make(take.fps, parameters), fed[take.name], take.times) for take in takes]
    )


def gathered(takes: Sequence[Take], runs: Sequence[tuple[Found, NDArray[np.float64], float]]) -> Race:
    """Return the runs over some takes as one race."""
    waits = np.concatenate([own for _, own, _ in runs])
    scores = [found.scores(take) for take, (found, _, _) in zip(takes, runs, strict=True)]
    return Race(
        len(waits),
        sum(found.seconds for found, _, _ in runs),
        sum(cpu for _, _, cpu in runs),
        waits,
        mean_scores(scores),
    )


def followed(
    detector: Detector, fed: NDArray[Any], times: NDArray[np.float64]
) -> tuple[Found, NDArray[np.float64], float]:
    """Feed a detector frame by frame.

    Returns:
        Its cuts; s that each update took; s of processor time.
    """
    waits = np.zeros(len(times))
    cuts: list[tuple[float, float]] = []
    cpu, clock = time.process_time(), time.perf_counter
    for i, moment in enumerate(times.tolist()):
        began = clock()
        found = detector.update(fed[i], moment)
        waits[i] = clock() - began
        cuts += [(cut, moment) for cut in found]
    began = clock()
    cuts += [(cut, float(times[-1])) for cut in detector.finish()]
    wall = float(waits.sum()) + clock() - began
    cpu = time.process_time() - cpu
    cuts.sort()
    return Found([cut for cut, _ in cuts], [at for _, at in cuts], wall), waits, cpu
