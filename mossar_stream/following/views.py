"""Views: the bytes of a bank and of a performer as numbers and records, for kernels."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.following.layout import (
    BONE,
    BONE_BYTES,
    EXAMPLE,
    EXAMPLE_BYTES,
    HEAD,
    HEAD_BYTES,
    LAYERS,
    MOVE,
    MOVE_BYTES,
    POINT,
    POINT_BYTES,
    RING,
    STATE,
    STATE_BYTES,
)
from mossar_stream.jit.decorators import inline_kernel
from mossar_stream.jit.views import part


class Bank(NamedTuple):
    """What is followed, described for a stream."""

    head: NDArray[np.void]  # (1,) HEAD
    points: NDArray[np.void]  # (K,) POINT
    bones: NDArray[np.void]  # (B,) BONE
    examples: NDArray[np.void]  # (T,) EXAMPLE
    rows: NDArray[np.float32]  # directions of all examples


class Memory(NamedTuple):
    """What is known of a performer, besides the cells of examples."""

    state: NDArray[np.void]  # (1,) STATE
    moves: NDArray[np.void]  # (M,) MOVE
    poses: NDArray[np.float32]  # (2, K, 3) m, of the last two frames
    directions: NDArray[np.float32]  # (3, lanes), of the sample
    strays: NDArray[np.float32]  # (M, lanes), mean square of the chord between each bone and the example's
    best: NDArray[np.float32]  # (M, lanes), the same at the best end
    ring: NDArray[np.float32]  # (RING, 3, lanes), directions of the last samples
    boxes: NDArray[np.float32]  # (M, 2, 3, lanes), least and largest directions of the last performance


class Cells(NamedTuple):
    """Where ways of aligning the stream with one example stand: one that ends in each phase, and layer."""

    starts: NDArray[np.float64]  # (LAYERS, n) s
    costs: NDArray[np.float32]  # (LAYERS, n) summed over phases; inf where there is no way
    sums: NDArray[np.float32]  # (LAYERS, n, lanes), the same for each bone
    weights: NDArray[np.float32]  # (LAYERS, n) of what was summed
    distances: NDArray[np.float32]  # (n,) of the sample
    parts: NDArray[np.float32]  # (n, lanes), the same for each bone


@inline_kernel(returns_views=True)
def open_bank(store):
    """Return the bank that a store holds."""
    head = part(store, 0, HEAD, (1,))
    points, bones, examples = head[0].points, head[0].bones, head[0].examples
    at_bones = HEAD_BYTES + points * POINT_BYTES
    at_examples = at_bones + bones * BONE_BYTES
    at_rows = at_examples + examples * EXAMPLE_BYTES
    return Bank(
        head,
        part(store, HEAD_BYTES, POINT, (points,)),
        part(store, at_bones, BONE, (bones,)),
        part(store, at_examples, EXAMPLE, (examples,)),
        part(store, at_rows, np.float32, ((store.size - at_rows) // 4,)),
    )


@inline_kernel(returns_views=True)
def open_memory(memory, head):
    """Return what is known of a performer."""
    points, lanes, moves = head.points, head.lanes, head.moves
    at_poses = STATE_BYTES + moves * MOVE_BYTES
    at_directions = at_poses + 4 * 2 * 3 * points
    at_strays = at_directions + 4 * 3 * lanes
    at_best = at_strays + 4 * moves * lanes
    at_ring = at_best + 4 * moves * lanes
    at_boxes = at_ring + 4 * RING * 3 * lanes
    return Memory(
        part(memory, 0, STATE, (1,)),
        part(memory, STATE_BYTES, MOVE, (moves,)),
        part(memory, at_poses, np.float32, (2, points, 3)),
        part(memory, at_directions, np.float32, (3, lanes)),
        part(memory, at_strays, np.float32, (moves, lanes)),
        part(memory, at_best, np.float32, (moves, lanes)),
        part(memory, at_ring, np.float32, (RING, 3, lanes)),
        part(memory, at_boxes, np.float32, (moves, 2, 3, lanes)),
    )


@inline_kernel(returns_views=True)
def open_cells(memory, example, lanes):
    """Return the cells of an example."""
    phases, begin = example.phases, example.memory
    at_costs = begin + 8 * LAYERS * phases
    at_sums = at_costs + 4 * LAYERS * phases
    at_distances = at_sums + 4 * LAYERS * phases * lanes
    at_weights = at_distances + 4 * phases
    at_parts = at_weights + 4 * LAYERS * phases
    return Cells(
        part(memory, begin, np.float64, (LAYERS, phases)),
        part(memory, at_costs, np.float32, (LAYERS, phases)),
        part(memory, at_sums, np.float32, (LAYERS, phases, lanes)),
        part(memory, at_weights, np.float32, (LAYERS, phases)),
        part(memory, at_distances, np.float32, (phases,)),
        part(memory, at_parts, np.float32, (phases, lanes)),
    )
