"""The bank: all examples described for the joints of one stream, as the recogniser compares them."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import (
    LEAD_COUNTED,
    LEAD_WORTH,
    MOST,
    RECORDS,
    SMOOTHED,
    STRICT_WORTH,
    move_numbers,
    move_store_bytes,
    move_store_parts,
    write_example,
)
from mossar_stream.moves.example import Example, smoothed
from mossar_stream.moves.facing import GIRDLES
from mossar_stream.moves.joints import Pair, shared_joints
from mossar_stream.moves.limbs import limbs_of
from mossar_stream.moves.parts import parts_of
from mossar_stream.moves.rules import USUAL, Facing, MoveRule
from mossar_stream.skeleton import Skeleton

MOVE_STORE = RECORDS["MoveStore"]


def make_store(
    shown: Skeleton,
    examples: Sequence[Example],
    rules: Mapping[str, MoveRule],
    streamed: Skeleton,
    facing: Facing,
    *,
    explains: bool = False,
) -> NDArray[np.uint8]:
    """Describe examples for a stream.

    Args:
        shown: Skeleton of the examples.
        examples: All of them.
        rules: Of each move, in the order in which they are numbered.
        streamed: Skeleton of the stream.
        facing: Whether moves are recognised from any side.
        explains: Whether movements that are not recognised are reported, too.

    Returns:
        Bytes: `MOVE_STORE`, then the parts of `store_of`.

    Raises:
        FrameError: If the stream lacks joints that the examples need.
    """
    slots, ours, theirs = shared_joints(shown, streamed)
    numbers = move_numbers(len(ours))
    store = np.zeros(move_store_bytes(len(ours), len(examples), len(rules)), np.uint8)
    girdles = [slots.index(slot) if slot in slots and facing == "any" else -1 for slot in GIRDLES]
    most = [MOST - STRICT_WORTH * (rule.strict - USUAL.strict) for rule in rules.values()]
    bar = np.exp(max(most, default=MOST) + LEAD_WORTH * LEAD_COUNTED)
    head = len(ours), len(examples), numbers, len(rules), bar, girdles, explains
    store[: MOVE_STORE.itemsize].view(MOVE_STORE)[0] = head
    parts = store_of(store)
    parts["joints"][:] = [tuple(place) for place in theirs]
    parts["limbs"][:] = _limbs_of(theirs, streamed)
    parts["rules"][:, 0], parts["rules"][:, 1] = most, [rule.again for rule in rules.values()]
    names = list(rules)
    for t, example in enumerate(examples):
        poses = example_poses(example, len(shown), ours, numbers)
        write_example(store, t, names.index(example.name), poses, path_of(poses))
    return store


def store_of(store: NDArray[np.uint8]) -> dict[str, NDArray[Any]]:
    """Return views of the parts of a store: `head`, `joints`, `limbs`, `examples`, `rules`."""
    return parts_of(store, move_store_parts(store))


def example_poses(example: Example, joints: int, pairs: Sequence[Pair], numbers: int) -> NDArray[np.float32]:
    """Return an example as the recogniser sees a stream: (n, D) metres, centre first, others relative to it."""
    positions = example.metres(joints).astype(np.float64)
    mean = positions.mean(axis=1)
    lines = [
        (positions[:, pair.one] + positions[:, pair.other]) / 2 if pair.one >= 0 else mean for pair in pairs
    ]
    placed = np.stack(lines, axis=1)
    placed[:, 1:] -= placed[:, :1]
    placed = smoothed(placed, SMOOTHED, example.fps)
    poses = np.zeros((len(placed), numbers), np.float32)
    poses[:, : 3 * len(pairs)] = placed.reshape(len(placed), -1)
    return poses


def path_of(poses: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the length of the path up to each pose, (n,) m."""
    steps = np.linalg.norm(np.diff(poses.astype(np.float64), axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _limbs_of(places: Sequence[Pair], streamed: Skeleton) -> list[int]:
    """Return the limb of the stream for each joint of the examples, -1 for none."""
    limbs = list(limbs_of(streamed).values())
    return [
        next((i for i, joints in enumerate(limbs) if place.one in joints and k > 0), -1)
        for k, place in enumerate(places)
    ]
