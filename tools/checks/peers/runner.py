"""Runner: a detector over takes, frame by frame, with a stopwatch."""

import time
from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from checks.peers.feeds import Feed, feed_of
from checks.peers.peer import Detector, Parameters, Peer
from mossar_tools.evaluation.detection import Detection
from mossar_tools.evaluation.metrics import Scores, mean_scores
from mossar_tools.evaluation.takes import Take


class TakeRun(msgspec.Struct, frozen=True):
    """Result of one take.

    Args:
        found: The cuts, and the time to find them from positions on, s.
        alone: s of this in the detector itself.
        cpu: s of processor time.
        waits: (n,) s from positions to cuts, for each frame; NaN where frames do not come one by one.
    """

    found: Detection
    alone: float
    cpu: float
    waits: NDArray[np.float64]


class PeerRun(msgspec.Struct, frozen=True):
    """Result of the takes of one group; sums of `TakeRun`.

    Args:
        frames: Of all takes.
        wall: s, from positions to cuts.
        alone: s of this in the detector itself.
        cpu: s of processor time.
        waits: (frames,) s.
        scores: Mean over the takes.
    """

    frames: int
    wall: float
    alone: float
    cpu: float
    waits: NDArray[np.float64]
    scores: Scores


def run_peer(takes: Sequence[Take], peer: Peer, parameters: Parameters) -> PeerRun:
    """Find the cuts of all takes with a peer."""
    return summed(
        takes, [run_take(peer.make(take.fps, parameters), feed_of(peer.feed, take), take) for take in takes]
    )


def summed(takes: Sequence[Take], follows: Sequence[TakeRun]) -> PeerRun:
    """Return the results of some takes as one run."""
    waits = np.concatenate([own.waits for own in follows])
    return PeerRun(
        frames=len(waits),
        wall=sum(own.found.seconds for own in follows),
        alone=sum(own.alone for own in follows),
        cpu=sum(own.cpu for own in follows),
        waits=waits,
        scores=mean_scores([own.found.scores(take) for take, own in zip(takes, follows, strict=True)]),
    )


def run_take(detector: Detector, feed: Feed, take: Take) -> TakeRun:
    """Feed a detector frame by frame."""
    positions = np.ascontiguousarray(take.positions)
    waits = np.zeros(len(take.times))
    cuts: list[tuple[float, float]] = []
    alone = 0.0
    cpu, clock = time.process_time(), time.perf_counter
    for i, moment in enumerate(take.times.tolist()):
        began = clock()
        sample = feed.sample(positions[i], moment)
        fed = clock()
        found = detector.update(sample, moment)
        ended = clock()
        waits[i] = ended - began
        alone += ended - fed
        cuts += [(cut, moment) for cut in found]
    began = clock()
    cuts += [(cut, float(take.times[-1])) for cut in detector.finish()]
    last = clock() - began
    cpu = time.process_time() - cpu
    cuts.sort()
    kept = Detection([cut for cut, _ in cuts], [at for _, at in cuts], float(waits.sum()) + last)
    return TakeRun(kept, alone + last, cpu, waits)
