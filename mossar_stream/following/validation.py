"""Validation: whether the memory of a followed performer that comes from outside is safe to use.

Compiled code does not check its indices. Every number that is used as an index must therefore point into the memory.
Numbers that are only calculated with may be nearly anything.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import CYCLES, LAYERS, PERIOD, follow_cell_parts, follow_memory_parts
from mossar_stream.events import LEFT_REASONS
from mossar_stream.following.bank import bank_of
from mossar_stream.moves.parts import parts_of

WAYS_ON = 2 * LAYERS  # steps by which a way comes on: from either layer, by one phase or two
MOST_COUNTED = 1 << 60  # no count is as large
LATEST_TIME = 1e15  # s
LONGEST_DIRECTION = 1.001  # of a bone, with rounding


def is_sound(memory: NDArray[np.uint8], store: NDArray[np.uint8]) -> bool:
    """Tell whether a performer's memory is one that following could have left.

    Args:
        memory: Bytes of it, as many as the bank calls for.
        store: The bank.
    """
    parts = parts_of(memory, follow_memory_parts(store))
    bank = bank_of(store)
    examples = bank["examples"]
    return (
        _time_goes_on(parts["state"][0])
        and all(_is_sound_move(move, examples) for move in parts["moves"])
        and _are_repetitions(parts["periods"][0])
        and all(_ways_stay_within(memory, store, t) for t in range(len(examples)))
        and all(
            bool((np.abs(parts[name]) <= LONGEST_DIRECTION).all())  # NaN is no direction either
            for name in ("boxes", "rings")
        )
    )


def _time_goes_on(state: np.void) -> bool:
    """Tell whether the next sample is due soon after the last frame; samples are counted anew after a gap."""
    times = [float(state[name]) for name in ("time", "begin", "sampled")]
    wait = int(state["samples"]) * PERIOD - (times[0] - times[1])
    return (
        all(0 <= int(state[name]) < MOST_COUNTED for name in ("frames", "samples", "number"))
        and state["due"] == -np.inf
        and bool(np.isfinite(times).all())
        and (0.0 <= wait <= 2 * PERIOD if state["frames"] else state["samples"] == 0)
    )


def _is_sound_move(move: np.void, examples: NDArray[np.void]) -> bool:
    """Tell whether the ways by which a move is followed lie in the cells of their examples."""
    counts = ("number", "count", "rev", "recents", "surplus")
    samples = ("first", "last", "best_first", "best_last", "done_first", "done_last")
    numbers = [float(move[name]) for name in ("start", "time", "seen", "reported", "progress")]
    return (
        all(0 <= int(move[name]) < MOST_COUNTED for name in counts)
        and all(abs(int(move[name])) < MOST_COUNTED for name in samples)
        and move["active"] in (0, 1)
        and move["repeated"] in (0, 1)
        and 0 <= int(move["refused"]) < len(LEFT_REASONS)
        and all(0 <= int(move[name]) < len(examples) for name in ("example", "best_example"))
        and all(0 <= int(move[name]) < LAYERS for name in ("layer", "best_layer"))
        and 0 <= int(move["phase"]) < int(examples[int(move["example"])]["phases"])
        and bool(np.isfinite(numbers).all())
        and 0.0 <= numbers[-1] <= 1.0
    )


def _are_repetitions(counted: np.void) -> bool:
    """Tell whether the counted repetitions lead to samples, remembered or not."""
    cycles = int(counted["cycles"])
    if not 0 <= cycles <= CYCLES:
        return False
    known = counted["cycle"][:cycles]
    times = np.array([known["begins"], known["ends"]]) + counted["origin"]
    return bool((np.abs(times) < LATEST_TIME).all())  # NaN is no time either


def _ways_stay_within(memory: NDArray[np.uint8], store: NDArray[np.uint8], t: int) -> bool:
    """Tell whether no way leads back beyond the first phase of example t."""
    steps = parts_of(memory, follow_cell_parts(store, t))["steps"]
    return bool((steps < WAYS_ON).all() and (steps[:, :2] % 2 == 0).all())
