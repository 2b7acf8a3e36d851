"""Hierarchy: Algorithms 1 to 3 over whole recordings with the paper's path kernel, by N, beside the paper's Table 7."""

from collections.abc import Iterator

from mossar_stream import Settings, segment_recording
from mossar_tools.bench.measurement import Measurement, duration, timed
from mossar_tools.bench.work import Work

EDGES = (5, 10, 15, 20, 25, 30, 35, 40, 45)  # N
# s for 15 recordings with L = 1: the paper's Table 7
TABLE_7 = {
    5: 149.021,
    10: 147.481,
    15: 155.244,
    20: 170.738,
    25: 291.488,
    30: 896.441,
    35: 3691.799,
    40: 16189.141,
}
TARGETS = {40: 0.1}  # s


def measure(work: Work) -> Iterator[Measurement]:
    """Yield the time from positions to strengths of all recordings together, for each N."""
    for edges in EDGES[:: work.some(1, 8)]:
        settings = Settings.build("paper", {"edges": edges})
        keys = segment_all(work, settings)
        runs = [timed(segment_all, work, settings) for _ in range(work.repeats)]
        name = f"N = {edges}, {len(work.recordings)} recordings, {keys} key frames"
        note = f"Table 7: {TABLE_7[edges]:,.0f} s for 15 recordings" if edges in TABLE_7 else ""
        yield duration("hierarchy", name, "s", runs, TARGETS.get(edges), note)


def segment_all(work: Work, settings: Settings) -> int:
    """Segment all recordings and return the number of key frames."""
    return sum(
        len(
            segment_recording(
                whole.positions, whole.fps, whole.skeleton, settings, times=whole.times
            ).key_frames
        )
        for whole in work.recordings
    )
