"""Views: the bytes of a bank and of a performer as numbers and records, for kernels."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mossar_stream.following.layout import (
    BANK_HEAD,
    BANK_HEAD_BYTES,
    BONE,
    BONE_BYTES,
    BONE_POINT,
    BONE_POINT_BYTES,
    FOLLOWED,
    FOLLOWED_BYTES,
    FOLLOWING_STATE,
    FOLLOWING_STATE_BYTES,
    LAYERS,
    LONGER,
    MOVE,
    MOVE_BYTES,
    REPORT,
)
from mossar_stream.jit.decorators import inline_kernel
from mossar_stream.jit.views import part


class Bank(NamedTuple):
    """What is followed, described for a stream."""

    head: NDArray[np.void]  # (1,) BANK_HEAD
    points: NDArray[np.void]  # (K,) BONE_POINT
    bones: NDArray[np.void]  # (B,) BONE
    examples: NDArray[np.void]  # (T,) FOLLOWED
    rows: NDArray[np.float32]  # the first pose, the directions of all examples, weights of bones


class Memory(NamedTuple):
    """What is known of a performer, besides the cells of examples."""

    state: NDArray[np.void]  # (1,) FOLLOWING_STATE
    moves: NDArray[np.void]  # (M,) MOVE
    happened: NDArray[np.int64]  # (M,) at the frame that the kernel stopped at
    reports: NDArray[np.float64]  # (M, REPORT and limbs)
    poses: NDArray[np.float32]  # (2, K, 3) m, of the last two frames
    absences: NDArray[np.float32]  # (K,) s, for which each point has been missing
    directions: NDArray[np.float32]  # (B, 3), of the sample
    distances: NDArray[np.float32]  # (n,) scratch: of the sample from each phase
    products: NDArray[np.float32]  # (n,) scratch: the same, how far it lies in the phase's direction
    strays: NDArray[np.float32]  # (M, B), mean square of chords; `UNJUDGED` of hidden bones
    boxes: NDArray[np.float32]  # (M, 2, B, 3), least and largest directions of the last performance
    rings: NDArray[np.float32]  # (R, ring, B, 3), directions of the last samples
    means: NDArray[np.float32]  # (B, 3) scratch: mean difference of directions along a way
    way: NDArray[np.int32]  # (2, 2·ring) scratch: samples and phases that a way brings together
    hidden: NDArray[np.uint8]  # (R, ring, B), whether each bone was hidden in the last samples


class Cells(NamedTuple):
    """Where ways of aligning the stream with one example stand: one that ends in each phase, and layer."""

    firsts: NDArray[np.int32]  # (LAYERS, n) sample where the way began
    costs: NDArray[np.float32]  # (LAYERS, n) summed over phases; inf where there is no way
    weights: NDArray[np.float32]  # (LAYERS, n) of what was summed
    gains: NDArray[np.float32]  # (LAYERS, n) summed over phases
    steps: NDArray[np.uint8]  # (ring, n) how ways have come on, at each sample


@inline_kernel(returns_views=True)
def open_bank(store):
    """Return the bank that a store holds."""
    head = part(store, 0, BANK_HEAD, (1,))
    points, bones, examples = head[0].points, head[0].bones, head[0].examples
    at_bones = BANK_HEAD_BYTES + points * BONE_POINT_BYTES
    at_examples = at_bones + bones * BONE_BYTES
    at_rows = at_examples + examples * FOLLOWED_BYTES
    return Bank(
        head,
        part(store, BANK_HEAD_BYTES, BONE_POINT, (points,)),
        part(store, at_bones, BONE, (bones,)),
        part(store, at_examples, FOLLOWED, (examples,)),
        part(store, at_rows, np.float32, ((store.size - at_rows) // 4,)),
    )


@inline_kernel(returns_views=True)
def open_memory(memory, head):
    """Return what is known of a performer."""
    points, bones, moves, ring, strides = head.points, head.bones, head.moves, head.ring, head.strides
    numbers = len(REPORT) + head.limbs
    at_happened = FOLLOWING_STATE_BYTES + moves * MOVE_BYTES
    at_reports = at_happened + 8 * moves
    at_poses = at_reports + 8 * moves * numbers
    at_absences = at_poses + 4 * 6 * points
    at_directions = at_absences + 4 * points
    at_distances = at_directions + 4 * 3 * bones
    at_products = at_distances + 4 * head.phases
    at_strays = at_products + 4 * head.phases
    at_boxes = at_strays + 4 * moves * bones
    at_rings = at_boxes + 4 * moves * 6 * bones
    at_means = at_rings + 4 * strides * ring * 3 * bones
    at_way = at_means + 4 * 3 * bones
    at_hidden = at_way + 4 * 4 * ring
    return Memory(
        part(memory, 0, FOLLOWING_STATE, (1,)),
        part(memory, FOLLOWING_STATE_BYTES, MOVE, (moves,)),
        part(memory, at_happened, np.int64, (moves,)),
        part(memory, at_reports, np.float64, (moves, numbers)),
        part(memory, at_poses, np.float32, (2, points, 3)),
        part(memory, at_absences, np.float32, (points,)),
        part(memory, at_directions, np.float32, (bones, 3)),
        part(memory, at_distances, np.float32, (head.phases,)),
        part(memory, at_products, np.float32, (head.phases,)),
        part(memory, at_strays, np.float32, (moves, bones)),
        part(memory, at_boxes, np.float32, (moves, 2, bones, 3)),
        part(memory, at_rings, np.float32, (strides, ring, bones, 3)),
        part(memory, at_means, np.float32, (bones, 3)),
        part(memory, at_way, np.int32, (2, 2 * ring)),
        part(memory, at_hidden, np.uint8, (strides, ring, bones)),
    )


@inline_kernel(returns_views=True)
def open_cells(memory, example):
    """Return the cells of an example."""
    phases, begin = example.phases, example.memory
    size = 4 * LAYERS * phases
    return Cells(
        part(memory, begin, np.int32, (LAYERS, phases)),
        part(memory, begin + size, np.float32, (LAYERS, phases)),
        part(memory, begin + 2 * size, np.float32, (LAYERS, phases)),
        part(memory, begin + 3 * size, np.float32, (LAYERS, phases)),
        part(memory, begin + 4 * size, np.uint8, (2 * phases + LONGER, phases)),
    )


@inline_kernel(returns_views=True)
def rows_of_example(bank, example):
    """Return the directions of an example, (B, 3, padded phases)."""
    return part(bank.rows, 4 * example.rows, np.float32, (bank.head[0].bones, 3, example.padded))


@inline_kernel(returns_views=True)
def first_pose(bank):
    """Return the points at the begin of the first example, relative to the centre, (K, 3) m."""
    return part(bank.rows, 0, np.float32, (bank.points.size, 3))


@inline_kernel(returns_views=True)
def weights_of_bones(bank):
    """Return how much each bone counts in the deviation from each example, (T, B); of one example they add up to 1."""
    examples, bones = bank.head[0].examples, bank.head[0].bones
    return part(bank.rows, 4 * (bank.rows.size - examples * bones), np.float32, (examples, bones))


@inline_kernel(returns_views=True)
def mean_of_example(bank, example):
    """Return the mean directions of an example, (B, 3)."""
    bones = bank.head[0].bones
    return part(bank.rows, 4 * (example.rows + 3 * bones * example.padded), np.float32, (bones, 3))
