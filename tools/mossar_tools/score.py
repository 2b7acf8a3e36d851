"""Score: which true cuts of the built-in performer were hit, while it performs."""

from collections import deque

import msgspec

from mossar_adapters.demo import Cut, DemoSource
from mossar_stream import KeyFrameEvent

TOLERANCE = 0.25  # s between a true cut and a key frame that hits it
PATIENCE = 1.0  # s after a cut until it counts as missed: key frames are confirmed with a delay

_KEPT = 512  # key frames kept for each performer


class Verdict(msgspec.Struct, frozen=True):
    """The outcome of a true cut.

    Args:
        performer: Name.
        cut: The cut.
        error: Time of the nearest confirmed key frame minus that of the cut, s; None if there is none near.
    """

    performer: str
    cut: Cut
    error: float | None


class Score:
    """Compares confirmed key frames with the true cuts.

    Args:
        sources: The built-in performers among the sources.
    """

    def __init__(self, sources: list[DemoSource]) -> None:
        self.cuts = 0
        self.hits = 0
        self.errors: deque[float] = deque(maxlen=10_000)  # s, of the hits
        self._sources = sources
        self._times: dict[str, deque[float]] = {}  # s, of the confirmed key frames of each performer
        self._judged: dict[str, float] = {}  # s, of each performer the last cut that was judged

    def cuts_of(self, performer: str) -> tuple[Cut, ...]:
        """Return the true cuts of a performer that are known so far."""
        return next((found.cuts[performer] for found in self._sources if performer in found.cuts), ())

    def add(self, event: KeyFrameEvent) -> None:
        """Add a confirmed key frame."""
        self._times.setdefault(event.performer, deque(maxlen=_KEPT)).append(event.time)

    def judge(self, now: dict[str, float]) -> list[Verdict]:
        """Return the outcome of the cuts that have had their time.

        Args:
            now: Time of the last frame of each performer, s; infinite at the end.
        """
        verdicts = []
        for source in self._sources:
            for performer, cuts in source.cuts.items():
                until = now.get(performer, 0.0) - PATIENCE
                since = self._judged.get(performer, -1.0)
                verdicts += [self._verdict(performer, cut) for cut in cuts if since < cut.time <= until]
                self._judged[performer] = max(since, until)
        return sorted(verdicts, key=lambda verdict: verdict.cut.time)

    def _verdict(self, performer: str, cut: Cut) -> Verdict:
        near = min((t - cut.time for t in self._times.get(performer, ())), key=abs, default=None)
        hit = near is not None and abs(near) <= TOLERANCE
        self.cuts += 1
        self.hits += hit
        if near is not None and hit:
            self.errors.append(near)
        return Verdict(performer, cut, near if hit else None)
