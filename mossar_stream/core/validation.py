"""Validation of rows from outside.

Compiled code does not check its indices. A row from a snapshot is therefore checked before any kernel sees it: every
index must point into the row. Other numbers may have any value.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import CYCLES, LINES, LIVE, NOT_KEPT, PAGE, RECORDS
from mossar_stream.core.plan import Plan
from mossar_stream.core.row import records, region
from mossar_stream.repetitions.preparing import is_sound as counting_is_sound
from mossar_stream.repetitions.preparing import prepare
from mossar_stream.similarity import protocol as similarity

FARTHEST_ORIGIN = 1e9  # m, largest distance of a performer from the origin
MOST_UNLABELLED = 100_000  # candidates without a label


def is_sound(row: NDArray[np.uint8], plan: Plan) -> bool:
    """Return whether all indices in a row point into it.

    Args:
        row: Bytes of the row, as long as the plan says, prepared.
        plan: Of the row.
    """
    state = records(row)
    sizes = state["plan"]
    if state["clock"]["open"] == 0:
        return True  # a new take sets everything
    undecided = int(state["window"]["undecided"])
    # Every key frame of the take was a candidate, and waits for its label for a second or two.
    candidates = int(state["window"]["ordinal"]) if plan.traits.has_features else 0
    limits = {
        ("clock", "open"): (1, 1),
        ("joints", "moving"): (1, sizes["joints"]),  # costs are divided by it
        ("joints", "arrived"): (0, 1),
        ("velocity", "head"): (0, sizes["ring"] - 1),
        ("velocity", "filled"): (0, sizes["ring"]),
        ("activity", "moving"): (0, 1),
        ("activity", "changed"): (0, 0),
        ("activity", "joint"): (-1, sizes["joints"] - 1),
        ("activity", "bouts"): (0, sizes["bouts"]),
        ("average", "head"): (0, max(0, sizes["average_size"] - 1)),
        ("average", "filled"): (0, max(0, sizes["average_size"])),
        ("history", "head"): (0, sizes["history_size"] - 1),
        ("history", "filled"): (0, sizes["history_size"]),
        ("dwells", "begun"): (0, 2**60),
        ("dwells", "noted"): (0, 2**60),
        ("ways", "home"): (0, 2**60),
        ("labels", "candidates"): (candidates, candidates),
        ("labels", "labelled"): (max(0, candidates - MOST_UNLABELLED), candidates),
        ("window", "undecided"): (0, sizes["capacity"]),
        ("window", "ordinal"): (undecided, 2**60),
        ("window", "has_before"): (0, 1),
        ("open_segment", "closed"): (-1, -1),
        ("open_segment", "fed"): (0, sizes["slot_count"] - 1),
    }
    within = (low <= int(state[record][name]) <= high for (record, name), (low, high) in limits.items())
    if state["curve"]["found"]["happened"] != 0 or not all(within):
        return False
    origin = [float(state["joints"][name]) for name in ("origin_x", "origin_y", "origin_z")]
    if not np.abs(origin).max() <= FARTHEST_ORIGIN:
        return False
    prepared = np.zeros(1, RECORDS["Counting"])[0]
    prepare(prepared, plan.skeleton, plan.channel)
    for own in region(row, "counted"):
        follows = own["begun"] == 1 and own["latest"] == state["clock"]["taken_time"]
        if not (follows and counting_is_sound(own, prepared)):
            return False
    periods = [*region(row, "periods"), *region(row, "adopted")]
    if not all(0 <= int(one["cycles"]) <= CYCLES for one in periods):
        return False
    live = region(row, "body").reshape(-1, LINES, PAGE)[:, LIVE // PAGE]
    if not np.isin(live, (0.0, 1.0)).all():
        return False
    return _slots_are_shared_out(row, plan) and _keys_follow_each_other(row)


def _slots_are_shared_out(row: NDArray[np.uint8], plan: Plan) -> bool:
    """Return whether every slot is used once or free, and holds a summary."""
    state = records(row)
    sizes = state["plan"]
    window, segment, unused_count = (
        state["window"],
        state["open_segment"],
        int(state["slots"]["unused_count"]),
    )
    unused, order = region(row, "unused"), region(row, "order")
    used = [int(segment[name]) for name in ("settled", "since", "run")]
    used += order[: int(window["undecided"])].tolist()
    used += [int(window["before"])] if window["has_before"] else []
    if unused_count != sizes["slot_count"] - len(used):
        return False
    used += unused[:unused_count].tolist()
    summaries = region(row, "summaries").reshape(sizes["slot_count"], sizes["slot"])
    return sorted(used) == list(range(sizes["slot_count"])) and similarity.are_sound(
        plan.settings, plan.params, summaries
    )


def _keys_follow_each_other(row: NDArray[np.uint8]) -> bool:
    """Return whether the undecided key frames are numbered through and refer to one another."""
    window = records(row)["window"]
    count, left = int(window["undecided"]), int(window["left_ordinal"])
    keys = region(row, "keys")[:count]
    first = int(window["ordinal"]) - count
    numbers, before = keys["ordinal"], keys["before"]
    earlier = (before >= first) & (before < numbers)
    return bool(
        -1 <= left < first
        and (numbers == np.arange(first, first + count)).all()
        and (earlier | (before == left) | (before == NOT_KEPT)).all()
        and ((keys["kind"] >= 0) & (keys["kind"] <= 2)).all()
        and ((keys["kept"] == 0) | (keys["kept"] == 1)).all()
        and ((keys["reported"] == 0) | (keys["reported"] == 1)).all()
    )
