"""Ours: mossar-stream beside the peers, with its defaults and the level of the labels."""

import time
from collections.abc import Sequence
from typing import Any

import msgspec
import msgspec.structs
import numpy as np
from numpy.typing import NDArray

from checks.peers.feeds import PositionFeed
from checks.peers.runner import PeerRun, TakeRun, run_take, summed
from mossar_stream import Event, KeyFrameEvent, Segmenter, Settings
from mossar_tools.evaluation.mossar import stream
from mossar_tools.evaluation.takes import Take

NAME = "mossar-stream"


class MossarDetector:
    """Final key frames are cuts.

    Args:
        take: The streamed take.
    """

    def __init__(self, take: Take) -> None:
        self._segmenter = Segmenter(take.skeleton, Settings(level=take.level), fps=take.fps)

    def update(self, sample: NDArray[Any], time: float) -> list[float]:
        """See `Detector`."""
        return _final(self._segmenter.push(sample, time))

    def finish(self) -> list[float]:
        """See `Detector`."""
        return _final(self._segmenter.end_take())


def _final(events: list[Event]) -> list[float]:
    return [event.time for event in events if isinstance(event, KeyFrameEvent) and event.status == "final"]


def one_by_one(takes: Sequence[Take]) -> PeerRun:
    """Return the result of pushing frame by frame."""
    return summed(takes, [run_take(MossarDetector(take), PositionFeed(), take) for take in takes])


def in_chunks(takes: Sequence[Take]) -> PeerRun:
    """Return the result of pushing chunks: the same key frames."""
    follows = []
    for take in takes:
        contiguous = msgspec.structs.replace(take, positions=np.ascontiguousarray(take.positions))
        cpu = time.process_time()
        found = stream(contiguous, Settings(), "final")
        cpu = time.process_time() - cpu
        follows.append(TakeRun(found, found.seconds, cpu, np.full(len(take.times), np.nan)))
    return summed(takes, follows)
