"""Chance: scores without regard to the motion, or to the segments between key frames.

Scores mean little without these beside them.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from mossar_stream import Settings
from mossar_tools.evaluation.detection import Detection, Method, Variants
from mossar_tools.evaluation.mossar import whole
from mossar_tools.evaluation.takes import Take

PERIODS = tuple(k / 4 for k in range(1, 81))  # s
RANDOM_CUTS = 50
RANDOM_MERGES = 24  # as many as the paper's pairs of N and L
SEED = 1
_KNOWS = "(knows the number of cuts)"  # in the names of methods, since no method that finds cuts knows it


def chance_methods(settings: Settings) -> Iterator[Method]:
    """Yield random merging, blind cuts and random cuts; the same numbers each time."""
    yield Method(f"random merging {_KNOWS}", ("best each",), lambda take: merged(take, settings))
    yield Method("a cut every k seconds", ("best for all",), blind)
    yield random_cuts()


def random_cuts() -> Method:
    """Return the method that cuts at random as often as there are true cuts."""
    return Method(f"random cuts {_KNOWS}", ("best each",), randomly)


def blind(take: Take) -> Variants:
    """Cut every k seconds."""
    first, last = float(take.times[0]), float(take.times[-1])
    return {f"{k:g} s": Detection(np.arange(first + k, last, k).tolist()) for k in PERIODS}


def randomly(take: Take) -> Variants:
    """Cut at random as often as there are true cuts."""
    rng = np.random.default_rng(SEED)
    size = (RANDOM_CUTS, len(take.cuts))
    cuts = np.sort(rng.uniform(float(take.times[0]), float(take.times[-1]), size))
    return {str(i): Detection(own.tolist()) for i, own in enumerate(cuts)}


def merged(take: Take, settings: Settings) -> Variants:
    """Remove the key frames of splitting in several random orders; every nested set is a variant."""
    rng = np.random.default_rng(SEED)
    keys = [key.time for key in whole(take, settings).key_frames]
    sets = {}
    for run in range(RANDOM_MERGES):
        sets.update(
            {f"{run}/{count}": own for count, own in nested(keys, rng.permutation(keys).tolist()).items()}
        )
    return sets


def nested(keys: Sequence[float], falling: Sequence[float]) -> Variants:
    """Return the nested sets of key frames, by their number.

    Args:
        keys: Times, s.
        falling: The same in the order of their removal.
    """
    kept = {len(keys): Detection(sorted(keys))}
    left = list(kept[len(keys)].times)
    for key in falling:
        left.remove(key)
        kept[len(left)] = Detection(list(left))
    return {str(count): found for count, found in kept.items()}
