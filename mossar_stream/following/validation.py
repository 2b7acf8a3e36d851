"""Validation: whether what is known of a followed performer, and comes from outside, can be worked on.

Compiled code does not check its indices. Whatever is used as an index must therefore point into the memory. Numbers
that are only calculated with may be nearly anything.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import LAYERS, PERIOD, RECORDS, follow_cell_parts, follow_memory_parts
from mossar_stream.events import LEFT_REASONS
from mossar_stream.following.bank import bank_of
from mossar_stream.following.bones import NOWHERE
from mossar_stream.moves.parts import parts_of

WAYS_ON = 2 * LAYERS  # steps by which a way comes on: from either layer, by one phase or two
MOST_COUNTED = 1 << 60  # no count is as large
REPORT = RECORDS["FollowReport"]
LONGEST_DIRECTION = 1.001  # of a bone, with rounding


def is_sound(memory: NDArray[np.uint8], store: NDArray[np.uint8]) -> bool:
    """Tell whether a performer's memory is one that following could have left.

    Args:
        memory: Bytes of it, as many as the bank calls for.
        store: The bank.
    """
    parts = parts_of(memory, follow_memory_parts(store))
    bank = bank_of(store)
    examples, bones = bank["examples"], len(bank["bones"])
    return (
        _time_goes_on(parts["state"][0])
        and all(_is_sound_move(move, examples) for move in parts["moves"])
        and all(_is_sound_report(report, len(examples), bones) for report in parts["near_reports"])
        and all(_ways_stay_within(memory, store, t) for t in range(len(examples)))
        and all(
            bool((np.abs(parts[name]) <= LONGEST_DIRECTION).all())  # NaN is no direction either
            for name in ("boxes", "near_boxes", "near_poses", "rings")
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
    counts = ("number", "count", "rev", "recents")
    samples = ("first", "last", "best_first", "best_last", "done_first", "done_last")
    near = move["near"]
    numbers = [float(move[name]) for name in ("start", "time", "seen", "reported", "progress")]
    return (
        all(0 <= int(move[name]) < MOST_COUNTED for name in counts)
        and all(abs(int(move[name])) < MOST_COUNTED for name in samples)
        and all(abs(int(near[name])) < MOST_COUNTED for name in ("first", "last"))
        and move["active"] in (0, 1)
        and near["is_known"] in (0, 1)
        and near["is_done"] in (0, 1)
        and 0 <= int(move["refused"]) < len(LEFT_REASONS)
        and all(0 <= int(move[name]) < len(examples) for name in ("example", "best_example"))
        and all(0 <= int(move[name]) < LAYERS for name in ("layer", "best_layer"))
        and 0 <= int(move["phase"]) < int(examples[int(move["example"])]["phases"])
        and bool(np.isfinite(numbers).all())
        and 0.0 <= numbers[-1] <= 1.0
    )


def _is_sound_report(report: NDArray[np.float64], examples: int, bones: int) -> bool:
    """Tell whether a report can be made an event: its first numbers are finite, and what is an index is in range."""
    fixed = report[: len(REPORT.names or ())]
    named = dict(zip(REPORT.names or (), fixed.tolist(), strict=True))
    return (
        bool(np.isfinite(fixed).all())
        and 0 <= named["refused"] < len(LEFT_REASONS)
        and named["example"] in range(examples)
        and named["joint"] in range(NOWHERE, bones)
        and abs(named["count"]) < MOST_COUNTED
        and 0.0 <= named["progress"] <= 1.0
    )


def _ways_stay_within(memory: NDArray[np.uint8], store: NDArray[np.uint8], t: int) -> bool:
    """Tell whether no way leads back beyond the first phase of example t."""
    steps = parts_of(memory, follow_cell_parts(store, t))["steps"]
    return bool((steps < WAYS_ON).all() and (steps[:, :2] % 2 == 0).all())
