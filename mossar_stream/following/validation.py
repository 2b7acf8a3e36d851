"""Validation: whether what is known of a followed performer, and comes from outside, can be worked on.

Compiled code does not check its indices. Whatever is used as an index must therefore point into the memory. Numbers
that are only calculated with may be nearly anything.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.following.bank import examples_of
from mossar_stream.following.layout import (
    BANK_HEAD,
    BANK_HEAD_BYTES,
    FOLLOWING_STATE,
    FOLLOWING_STATE_BYTES,
    LAYERS,
    MOVE,
    MOVE_BYTES,
    PERIOD,
    REPORT,
    ring_size,
)

WAYS_ON = 2 * LAYERS  # steps by which a way comes on: from either layer, by one phase or two
MOST_COUNTED = 1 << 60  # no count is as large
LONGEST_DIRECTION = 1.001  # of a bone, with rounding


def is_sound(memory: NDArray[np.uint8], store: NDArray[np.uint8]) -> bool:
    """Tell whether a performer's memory is one that following could have left.

    Args:
        memory: Bytes of it, as many as the bank calls for.
        store: The bank.
    """
    count = int(_head(store)["moves"])
    state = memory[:FOLLOWING_STATE_BYTES].view(FOLLOWING_STATE)[0]
    moves = memory[FOLLOWING_STATE_BYTES : FOLLOWING_STATE_BYTES + count * MOVE_BYTES].view(MOVE)
    return (
        _time_goes_on(state)
        and all(_is_sound_move(move, examples_of(store)) for move in moves)
        and all(_ways_stay_within(memory, example) for example in examples_of(store))
        and bool((np.abs(_directions(memory, store)) <= LONGEST_DIRECTION).all())
    )


def _time_goes_on(state: np.void) -> bool:
    """Tell whether the next sample is due soon after the last frame; it is set anew with the first frame after a gap."""
    times = [float(state[name]) for name in ("time", "next", "sampled")]
    wait = times[1] - times[0]
    return (
        all(0 <= int(state[name]) < MOST_COUNTED for name in ("frames", "samples", "number"))
        and state["due"] == -np.inf
        and bool(np.isfinite(times).all())
        and wait <= 2 * PERIOD
        and (state["frames"] == 0 or wait >= 0.0)
    )


def _is_sound_move(move: np.void, examples: NDArray[np.void]) -> bool:
    """Tell whether the ways by which a move is followed lie in the cells of their examples."""
    counts = ("number", "count", "rev", "recents")
    samples = ("first", "last", "best_first", "best_last", "done_first", "done_last")
    numbers = [float(move[name]) for name in ("start", "time", "seen", "reported", "progress")]
    return (
        all(0 <= int(move[name]) < MOST_COUNTED for name in counts)
        and all(abs(int(move[name])) < MOST_COUNTED for name in samples)
        and move["active"] in (0, 1)
        and all(0 <= int(move[name]) < len(examples) for name in ("example", "best_example"))
        and all(0 <= int(move[name]) < LAYERS for name in ("layer", "best_layer"))
        and 0 <= int(move["phase"]) < int(examples[int(move["example"])]["phases"])
        and bool(np.isfinite(numbers).all())
        and 0.0 <= numbers[-1] <= 1.0
    )


def _ways_stay_within(memory: NDArray[np.uint8], example: np.void) -> bool:
    """Tell whether no way leads back beyond the first phase of its example."""
    phases = int(example["phases"])
    at = int(example["memory"]) + 16 * LAYERS * phases
    steps = memory[at : at + ring_size(phases) * phases].reshape(-1, phases)
    return bool((steps < WAYS_ON).all() and (steps[:, :2] % 2 == 0).all())


def _directions(memory: NDArray[np.uint8], store: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return the directions of bones that are remembered: boxes, then rings."""
    head = _head(store)
    moves, bones, phases = int(head["moves"]), int(head["bones"]), int(head["phases"])
    at = FOLLOWING_STATE_BYTES + moves * (MOVE_BYTES + 8 + 8 * (len(REPORT) + int(head["limbs"])))
    at += 4 * (7 * int(head["points"]) + 3 * bones + 2 * phases + moves * bones)
    count = 3 * bones * (2 * moves + int(head["strides"]) * int(head["ring"]))
    return memory[at : at + 4 * count].view(np.float32)


def _head(store: NDArray[np.uint8]) -> np.void:
    found: np.void = store[:BANK_HEAD_BYTES].view(BANK_HEAD)[0]
    return found
