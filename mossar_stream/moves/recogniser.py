"""The recogniser as Python sees it: the memory of a performer. The kernels are in `recogniser.pxi`."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import (
    RECORDS,
    move_memory_bytes,
    move_memory_parts,
)
from mossar_stream.moves.parts import parts_of

RECOGNITION_STATE = RECORDS["RecognitionState"]


def memory_of(memory: NDArray[np.uint8], joints: int, moves: int) -> dict[str, NDArray[Any]]:
    """Return views of the parts of a performer's memory: `state`, `poses`, `last_times`.

    Args:
        memory: Of a performer.
        joints: Of the examples.
        moves: Number of moves.
    """
    return parts_of(memory, move_memory_parts(joints, moves))


def new_memory(joints: int, moves: int) -> NDArray[np.uint8]:
    """Return the memory of a new performer; see `memory_of`."""
    memory = np.zeros(move_memory_bytes(joints, moves), np.uint8)
    parts = memory_of(memory, joints, moves)
    state = parts["state"][0]
    state["due"] = -np.inf
    for which in ("found", "before"):
        state[which]["move"] = -1
    state["nearest"]["move"] = state["nearest"]["second"] = -1
    parts["last_times"][:] = -np.inf
    return memory
