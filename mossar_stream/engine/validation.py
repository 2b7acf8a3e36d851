"""Soundness: whether a row that comes from outside can be worked on.

Compiled code does not check its indices. A row from a snapshot is therefore looked through before any kernel sees
it: whatever is used as an index must point into the row. Numbers that are only calculated with may be anything.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.window import NOT_STANDING
from mossar_stream.engine.plan import Plan
from mossar_stream.memory.row import header, region
from mossar_stream.similarity import protocol as similarity


def is_sound(row: NDArray[np.uint8], plan: Plan) -> bool:
    """Tell whether all indices in a row point into it.

    Args:
        row: Bytes of the row, as long as the plan says, prepared.
        plan: Of the row.
    """
    h, shape = header(row), plan.shape
    if h["open"] == 0:
        return True  # a new take sets everything
    limits = {
        "open": (1, 1),
        "head": (0, shape.ring - 1),
        "filled": (0, shape.ring),
        "average_head": (0, max(0, shape.smoothing_window - 1)),
        "average_filled": (0, max(0, shape.smoothing_window)),
        "trail_head": (0, shape.trail - 1),
        "trail_filled": (0, shape.trail),
        "undecided": (0, shape.window),
        "ordinal": (int(h["undecided"]), 2**60),
        "closed": (-1, -1),
        "fed": (0, shape.slots - 1),
        "happened": (0, 0),
        "has_before": (0, 1),
    }
    if not all(low <= int(h[name]) <= high for name, (low, high) in limits.items()):
        return False
    return _slots_are_shared_out(row, plan) and _keys_follow_each_other(row, plan)


def _slots_are_shared_out(row: NDArray[np.uint8], plan: Plan) -> bool:
    """Tell whether every slot is used once or free, and holds a summary."""
    h, shape = header(row), plan.shape
    free, order = region(row, shape, "free"), region(row, shape, "order")
    used = [int(h[name]) for name in ("slot_settled", "slot_since", "slot_run")]
    used += order[: int(h["undecided"])].tolist()
    used += [int(h["slot_before"])] if h["has_before"] else []
    if h["free_count"] != shape.slots - len(used):
        return False
    used += free[: int(h["free_count"])].tolist()
    slots = region(row, shape, "slots").reshape(shape.slots, shape.slot)
    return sorted(used) == list(range(shape.slots)) and similarity.are_sound(
        plan.settings, plan.params, slots
    )


def _keys_follow_each_other(row: NDArray[np.uint8], plan: Plan) -> bool:
    """Tell whether the undecided key frames are numbered through and refer to one another."""
    h = header(row)
    count, left = int(h["undecided"]), int(h["left_ordinal"])
    keys = region(row, plan.shape, "keys")[:count]
    first = int(h["ordinal"]) - count
    numbers, before = keys["ordinal"], keys["before"]
    earlier = (before >= first) & (before < numbers)
    return bool(
        -1 <= left < first
        and (numbers == np.arange(first, first + count)).all()
        and (earlier | (before == left) | (before == NOT_STANDING)).all()
        and ((keys["kind"] >= 0) & (keys["kind"] <= 2)).all()
        and ((keys["standing"] == 0) | (keys["standing"] == 1)).all()
    )
