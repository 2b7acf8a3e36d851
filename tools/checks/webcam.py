"""`python -m checks.webcam VIDEO`: the cost of poses from pictures, and the effect of their jitter on key frames.

Rates and delays are of this machine, one thread for the networks. With `--live MINUTES`, on Linux, the clip is a camera
at 25 Hz for a `mossar run` of its own. The delay is from a grab to the line of a `confirmed` event, and the share of a core
includes decoding. Without it times are those of the processor, for estimate and segmentation alone. Agreement: the final key frames of level `motion` from eight estimates of one clip,
pair by pair, within 0.25 s.
"""

import argparse
import itertools
import resource
import statistics
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from checks.webcam_live import live
from mossar_adapters.pose.following import Estimator
from mossar_adapters.pose.pictures import Picture, pictures
from mossar_adapters.pose.settings import DEFAULTS
from mossar_adapters.pose.types import SKELETON
from mossar_adapters.pose.weights import weights
from mossar_stream import KeyFrameEvent, Segmenter, Settings
from mossar_tools.evaluation.matching import Cut, match

TOLERANCE: Final = 0.25  # s
RATE: Final = 25.0  # Hz, of the share of a core
MOST: Final = 600  # pictures of a clip
# Of an estimate: model, whether it is smoothed, pixels by which pictures are shifted, Hz.
ESTIMATES: Final = (
    ("full", True, 0, 30.0),
    ("lite", True, 0, 30.0),
    ("full", False, 0, 30.0),
    ("lite", False, 0, 30.0),
    ("full", True, 1, 30.0),
    ("lite", True, 1, 30.0),
    ("full", True, 0, 25.0),
    ("lite", True, 0, 25.0),
)
Frame = tuple[float, NDArray[np.float32], NDArray[np.float32]]


def at_rate(path: Path, fps: float, shift: int) -> Iterator[tuple[Picture, float]]:
    """Yield the pictures of a clip nearest to this rate, Hz, shifted by so many pixels."""
    due = -np.inf
    matrix = np.array([[1, 0, shift], [0, 1, shift]], np.float32)
    for picture, moment in itertools.islice(pictures(path), MOST):
        if moment + 0.25 / fps < due:
            continue
        due = max(due + 1 / fps, moment) if np.isfinite(due) else moment + 1 / fps
        height, width = picture.shape[:2]
        yield (cv2.warpAffine(picture, matrix, (width, height)) if shift else picture), moment  # type: ignore[misc]


def estimated(path: Path, model: str, smooth: bool, shift: int, fps: float) -> list[Frame]:
    """Return times, positions and confidence of the person in a clip."""
    estimator = Estimator(weights(model), smooth=smooth)
    found = []
    for picture, moment in at_rate(path, fps, shift):
        found += [
            (moment, body.positions, body.confidence) for body in estimator.estimate(picture, moment)[:1]
        ]
    return found


def final_times(frames: list[Frame], **settings: Any) -> list[float]:
    """Return the times of the final key frames, s."""
    segmenter = Segmenter(SKELETON, Settings(**settings))
    events = []
    for moment, positions, confidence in frames:
        events += segmenter.push(positions, moment, confidence)
    events += segmenter.end_take()
    return sorted(e.time for e in events if isinstance(e, KeyFrameEvent) and e.status == "final")


def agreement(one: list[float], other: list[float]) -> float:
    """Return the F1 of two lists of times, matched one to one within the tolerance."""
    hits = len(match(one, [Cut(moment, moment, moment) for moment in other], TOLERANCE))
    return 2 * hits / (len(one) + len(other)) if one or other else 1.0


def costs(path: Path, model: str) -> str:
    """Return one line: pictures a second, time from a picture to the events of its frame, share of a core at 25 Hz.

    Times are those of the processor, without decoding the video and without other programs.
    """
    estimator, segmenter = Estimator(weights(model)), Segmenter(SKELETON, Settings.build(overrides=DEFAULTS))
    estimates, delays = [], []
    for picture, moment in itertools.islice(pictures(path), MOST // 2):
        begin = time.process_time()
        bodies = estimator.estimate(picture, moment)
        estimates.append(time.process_time() - begin)
        for body in bodies[:1]:
            segmenter.push(body.positions, moment, body.confidence)
        delays.append(time.process_time() - begin)
    p50, p95 = np.percentile(np.array(delays[5:]) * 1e3, [50, 95])
    rate = 1 / statistics.median(estimates[5:])
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return (
        f"{model}: {rate:.0f} pictures/s (median), picture to events {p50:.1f} ms p50, {p95:.1f} ms p95, "
        f"{statistics.mean(delays[5:]) * RATE:.2f} of a core at {RATE:.0f} Hz, at most {memory:.0f} MB"
    )


def main() -> None:
    """Print costs and agreement."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("video", type=Path)
    parser.add_argument("--level", default="motion")
    parser.add_argument("--costs", action="store_true", help="costs alone")
    parser.add_argument("--live", metavar="MINUTES", type=float, help="a run at real speed, and nothing else")
    parser.add_argument("--model", default="full", help="of --live; default: full")
    options = parser.parse_args()
    if options.live:
        print(live(options.video, options.model, options.live, RATE))
        return
    for model in ("lite", "full"):
        print(costs(options.video, model), flush=True)
    if options.costs:
        return
    found = []
    for estimate in ESTIMATES:
        found.append(final_times(estimated(options.video, *estimate), level=options.level, **DEFAULTS))
        print(f"{estimate}: {len(found[-1])} final key frames", flush=True)
    pairs = [agreement(a, b) for a, b in itertools.combinations(found, 2)]
    print(
        f"agreement of {len(found)} estimates: F1 {statistics.mean(pairs):.2f}, the worst pair {min(pairs):.2f}"
    )


if __name__ == "__main__":
    main()
