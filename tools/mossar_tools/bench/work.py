"""Work: the material of the measures, and their thoroughness."""

from collections.abc import Callable, Sequence

import msgspec
import msgspec.structs
import numpy as np

from mossar_adapters.files.loaded import LoadedRecording
from mossar_tools.bench.motion import JOINTS, Motion, joined, performer, to_and_fro


class Work(msgspec.Struct, frozen=True):
    """The shared material of the measures.

    Args:
        motions: Each is gone through; the first one where one is enough.
        single: One recording without a break.
        recordings: Real recordings of the first motion, as they are; the performer's where there are none.
        repeats: How often each run is repeated.
        quick: Whether to look only whether everything works.
        on_progress: Gets the current step, for a status line.
    """

    motions: list[Motion]
    single: Motion
    recordings: list[LoadedRecording]
    repeats: int = 5
    quick: bool = False
    on_progress: Callable[[str], None] = lambda _: None

    def some(self, much: int, little: int) -> int:
        """Return `much`, or `little` if it has to be quick."""
        return little if self.quick else much


PERFORMER_SECONDS, QUICK_SECONDS = 120.0, 4.0


def prepare(wholes: Sequence[LoadedRecording], *, quick: bool, on_progress: Callable[[str], None]) -> Work:
    """Return the work on some recordings, and on the built-in performer.

    Of recordings with several skeletons those are taken whose number of joints is nearest to `JOINTS`.
    """
    own = performer(QUICK_SECONDS if quick else PERFORMER_SECONDS)
    # Readers may lay positions out otherwise; copying them is not measured.
    usable = [
        msgspec.structs.replace(whole, positions=np.ascontiguousarray(whole.positions))
        for whole in wholes
        if whole.fps and len(whole.times) > 2
    ]
    repeats = 2 if quick else 5
    if not usable:
        count = len(own.times) // 2 + 1
        whole = LoadedRecording(own.name, own.skeleton, own.fps, own.positions[:count], own.times[:count])
        return Work([own], own, [whole], repeats, quick, on_progress)
    nearest = min(usable, key=lambda whole: abs(len(whole.skeleton) - JOINTS))
    alike = [
        whole for whole in usable if len(whole.skeleton) == len(nearest.skeleton) and whole.fps == nearest.fps
    ]
    motions = [to_and_fro(whole.name, whole.skeleton, whole.fps or 0.0, whole.positions) for whole in alike]
    name = f"{len(alike)} real recordings, {len(nearest.skeleton)} joints"
    longest = max(motions, key=lambda motion: len(motion.times))
    return Work([joined(name, motions), own], longest, alike, repeats, quick, on_progress)
