"""Precompiling: kernels are compiled, or loaded from the disk, before there is anybody to follow."""

from collections.abc import Callable
from typing import cast

import numpy as np

from mossar_stream.engine.middle import set_middle
from mossar_stream.engine.plan import Plan
from mossar_stream.engine.warm_up import warm_up, warm_up_analysis, warm_up_decisions, warm_up_frames
from mossar_stream.jit.cache import open_cache
from mossar_stream.jit.precompile import other_processes
from mossar_stream.moves.kinds import costs_of, described
from mossar_stream.moves.moves import Moves
from mossar_stream.segmenter import Segmenter
from mossar_stream.settings import Settings, SimilarityName
from mossar_stream.skeleton import Skeleton
from mossar_stream.steps.stepping import Stepping

DECISIONS_PART, FRAMES_PART, ANALYSIS_PART, MOVES_PART = "decisions", "frames", "repetitions", "moves"
STEPS_PART, RECORDINGS_PART = "steps", "recordings"
Progress = Callable[[str, int, int], None]
_READY: set[tuple[str, SimilarityName]] = set()  # parts whose kernels are there
_ANYBODY = Skeleton(("a", "b"), (-1, 0))


def _say_nothing(_part: str, _done: int, _parts: int) -> None:
    pass


def precompile(
    settings: Settings | None = None,
    *,
    moves: bool = False,
    recordings: bool = False,
    progress: Progress = _say_nothing,
) -> None:
    """Compile the kernels that segmenters with these settings need, on two cores where there are two.

    They are left in a cache on disk, for this process and those to come; where they lie there already this takes a
    fraction of a second. A segmenter that is built without it compiles them itself, on one core. Other Python
    processes are started only if something must be compiled, and have ended when this returns.

    Args:
        settings: Defaults to `Settings()`; only the similarity measure, and whether there are repetitions and steps,
            matter here.
        moves: Whether moves are to be recognised.
        recordings: Whether to compile, too, what only whole recordings need: the search for kinds of movements, and limbs
            that hang on the centroid.
        progress: Called before each part with its name, how many parts are done, and how many there are.

    Raises:
        MossarError: If there is nowhere to write compiled kernels to.

    Example:
        >>> precompile(Settings(similarity="likelihood"))
    """
    resolved = (settings or Settings()).resolved()
    similarity = resolved.similarity
    wanted = {DECISIONS_PART: True, FRAMES_PART: True, ANALYSIS_PART: _any_plan(similarity).shape.repetitions}
    wanted |= {MOVES_PART: moves}
    wanted[ANALYSIS_PART] |= resolved.repetitions
    wanted |= {STEPS_PART: resolved.steps, RECORDINGS_PART: recordings}
    parts = [part for part, needed in wanted.items() if needed and (part, similarity) not in _READY]
    if not parts:
        return
    progress(parts[0], 0, len(parts))
    # What moves add needs the rest, which another process would compile a second time.
    others = [part for part in parts[1:] if part in {FRAMES_PART, ANALYSIS_PART}]
    with other_processes(__name__, [f"{part} {similarity}" for part in others]):
        _compile(parts[0], similarity)
    for done, part in enumerate(parts[1:], 1):
        progress(part, done, len(parts))
        _compile(part, similarity)
    warm_up(_any_plan(similarity))
    _READY.update((part, similarity) for part in parts)


def compile_part(folder: str, part: str) -> None:
    """Compile what `precompile` leaves to another process, if this one has the same cache.

    Args:
        folder: Of the cache.
        part: Its name and the similarity measure.
    """
    if folder == str(open_cache().folder):
        name, _, similarity = part.partition(" ")
        _compile(name, cast("SimilarityName", similarity))


def _compile(part: str, similarity: SimilarityName) -> None:
    """Compile one part, or load it."""
    plan = _any_plan(similarity)
    if part == DECISIONS_PART:
        warm_up_decisions(plan)
    elif part == FRAMES_PART:
        warm_up_frames(plan)
    elif part == ANALYSIS_PART:
        warm_up_analysis()
    elif part == STEPS_PART:
        Stepping(_ANYBODY, Settings(feet="left=a right=b"), "p1")
    elif part == RECORDINGS_PART:
        moves = _any_moves()
        costs_of(_ANYBODY, described(_ANYBODY, moves.examples, "any"), moves.examples[0])
        set_middle(plan.new_rows(1)[0], np.zeros(3, np.float32))
    else:
        Segmenter(_ANYBODY, Settings(similarity=similarity), moves=_any_moves(), follow=True)


def _any_plan(similarity: SimilarityName) -> Plan:
    return Plan(_ANYBODY, Settings(similarity=similarity), None)


def _any_moves() -> Moves:
    """Return moves of one example and one pose, for the sake of the kernels."""
    there = np.zeros((10, 2, 3))
    there[:, 1, 0] = np.linspace(0.0, 1.0, 10)
    moves = Moves(_ANYBODY)
    moves.add("any", there, 30)
    moves.add_pose("held", there[0] + [[0, 0, 0], [0, 1, 0]])
    return moves
