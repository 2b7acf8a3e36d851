"""Ours: mossar-stream in the contest, with its defaults and the level of the labels."""

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream.events import Event, KeyFrameEvent
from mossar_stream.segmenter import Segmenter
from mossar_stream.settings import Settings
from mossar_tools.bench.peers.contest import Race, followed, gathered
from mossar_tools.evaluation.mossar import stream
from mossar_tools.evaluation.takes import Take

NAME = "mossar-stream"


class MossarDetector:
    """Final key frames are cuts.

    Args:
        take: What is streamed.
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


def one_by_one(takes: list[Take]) -> Race:
    """Return what comes of pushing frame by frame."""
    return gathered(takes, [followed(MossarDetector(take), take.positions, take.times) for take in takes])


def in_chunks(takes: list[Take]) -> Race:
    """Return what comes of pushing chunks; the same key frames."""
    runs = []
    for take in takes:
        cpu = time.process_time()
        found = stream(take, Settings(), "final")
        runs.append((found, np.full(len(take.times), np.nan), time.process_time() - cpu))
    return gathered(takes, runs)
