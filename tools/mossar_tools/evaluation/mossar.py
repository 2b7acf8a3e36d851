"""Mossar: the methods of this project, at the level of a take's labels."""

import time
from collections.abc import Iterator
from typing import get_args

from mossar_stream import KernelForm, KeyFrameEvent, Result, Segmenter, Settings, segment_recording
from mossar_tools.evaluation.detection import FIXED, Detection, Method, Variants
from mossar_tools.evaluation.takes import Take

CHUNK = 64  # frames pushed at once; events do not depend on it


def mossar_methods(settings: Settings) -> Iterator[Method]:
    """Yield splitting alone, then every similarity, each streaming and offline.

    Args:
        settings: Common settings; the level is that of each take.
    """
    yield _streaming("splitting alone, streaming", settings, "confirmed")
    yield Method("splitting alone, offline", FIXED, lambda take: _only(split(take, settings)))
    for name, chosen in similarities(settings).items():
        yield _streaming(f"Mossar {name}, streaming", chosen, "final")
        yield _offline(f"Mossar {name}, offline", chosen)


def similarities(settings: Settings) -> dict[str, Settings]:
    """Return settings with each similarity, by name."""
    forms: list[KernelForm] = list(get_args(KernelForm))
    return {
        "default": settings.replace(similarity=None),
        "likelihood": settings.replace(similarity="likelihood"),
        **{
            f"path kernel {form}": settings.replace(similarity="path_kernel", kernel_form=form)
            for form in forms
        },
    }


def at_level_of(take: Take, settings: Settings) -> Settings:
    """Return settings with the level of a take.

    Another similarity than `evidence` at level `motion` takes the windows and weights of the bundle of `posture`, which were
    fitted for it, and the strength of `motion`.
    """
    if take.level != "motion" or settings.similarity in (None, "evidence"):
        return settings.replace(level=take.level)
    usual = settings.replace(level="posture").bundle_values()
    own = {name: value for name, value in usual.items() if getattr(settings, name) is None}
    return settings.replace(level=settings.strength("motion"), **own)


def stream(take: Take, settings: Settings, status: str) -> Detection:
    """Stream a take and return its key frames as they were when they reached a status.

    Args:
        take: The take to stream.
        settings: Of the segmenter; the level is the take's.
        status: `confirmed` (before remerging) or `final`.
    """
    segmenter = Segmenter(take.skeleton, at_level_of(take, settings), fps=take.fps)
    return found_in(segmenter, take, status)


def found_in(segmenter: Segmenter, take: Take, status: str) -> Detection:
    """Return the same with a given segmenter."""
    events = []
    began = time.perf_counter()
    for start in range(0, len(take.times), CHUNK):
        chunk = slice(start, start + CHUNK)
        events += segmenter.push(take.positions[chunk], take.times[chunk])
    events += segmenter.end_take()
    seconds = time.perf_counter() - began
    keys = [event for event in events if isinstance(event, KeyFrameEvent) and event.status == status]
    keys.sort(key=lambda event: event.time)
    return Detection([event.time for event in keys], [event.decided_time for event in keys], seconds)


def split(take: Take, settings: Settings) -> Detection:
    """Return all key frames of Algorithm 2, with the range of the whole recording."""
    began = time.perf_counter()
    result = whole(take, settings)
    return Detection([key.time for key in result.key_frames], seconds=time.perf_counter() - began)


def whole(take: Take, settings: Settings) -> Result:
    """Return the offline segmentation of a take, with the range of the whole recording."""
    chosen = at_level_of(take, settings).replace(range="file")
    return segment_recording(take.positions, take.fps, take.skeleton, chosen, times=take.times)


def _streaming(name: str, settings: Settings, status: str) -> Method:
    return Method(name, FIXED, lambda take: _only(stream(take, settings, status)), online=True)


def _offline(name: str, settings: Settings) -> Method:
    def run(take: Take) -> Variants:
        began = time.perf_counter()
        kept = whole(take, settings).at(at_level_of(take, settings).level).key_frames
        return _only(Detection([key.time for key in kept], seconds=time.perf_counter() - began))

    return Method(name, FIXED, run)


def _only(found: Detection) -> Variants:
    return {"": found}
