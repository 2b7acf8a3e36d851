"""The bank: all examples described for the joints of one stream, as the recogniser compares them."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.cache import open_cache
from mossar_stream.jit.decorators import entry_point
from mossar_stream.jit.simd import line_product, padded
from mossar_stream.moves.example import Example, smoothed
from mossar_stream.moves.facing import GIRDLES
from mossar_stream.moves.joints import Pair, shared_joints
from mossar_stream.moves.limbs import limbs_of
from mossar_stream.moves.measure import DIRECTIONS, NEVER, correction, describe, strangeness, warped
from mossar_stream.moves.recogniser import (
    EXAMPLE_BYTES,
    JOINT_BYTES,
    LEAD_COUNTED,
    LEAD_WORTH,
    MOST,
    ROWS,
    RULE,
    RULE_BYTES,
    STORE,
    STORE_BYTES,
    STRICT_WORTH,
    open_store,
    store_bytes,
)
from mossar_stream.moves.rules import USUAL, Facing, MoveRule
from mossar_stream.moves.track import JOINT, SMOOTHED
from mossar_stream.skeleton import Skeleton


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
        A store, as `recogniser.open_store` opens it.

    Raises:
        FrameError: If the stream lacks joints that the examples need.
    """
    slots, ours, theirs = shared_joints(shown, streamed)
    open_cache()
    numbers = padded(3 * len(ours))
    store = np.zeros(store_bytes(len(ours), len(examples), len(rules)), np.uint8)
    girdles = [slots.index(slot) if slot in slots and facing == "any" else -1 for slot in GIRDLES]
    most = [MOST - STRICT_WORTH * (rule.strict - USUAL.strict) for rule in rules.values()]
    bar = np.exp(max(most, default=MOST) + LEAD_WORTH * LEAD_COUNTED)
    store[:STORE_BYTES].view(STORE)[0] = len(ours), len(examples), numbers, len(rules), bar, girdles, explains
    store[STORE_BYTES : STORE_BYTES + len(ours) * JOINT_BYTES].view(JOINT)[:] = _joint_records(
        theirs, streamed
    )
    at_rules = STORE_BYTES + len(ours) * JOINT_BYTES + len(examples) * EXAMPLE_BYTES
    records = store[at_rules : at_rules + len(rules) * RULE_BYTES].view(RULE)
    records["most"], records["again"] = most, [rule.again for rule in rules.values()]
    names = list(rules)
    for t, example in enumerate(examples):
        poses = example_poses(example, len(shown), ours, numbers)
        write_example(store, t, names.index(example.name), poses, path_of(poses))
    return store


@entry_point
def write_example(store, t, move, poses, path):
    """Describe the whole of an example, number t; see `measure.describe`."""
    bank = open_store(store)
    if t == 0:
        for d in range(bank.begin.size):
            bank.begin[d] = poses[0, d]
    describe(poses, path, 0, path.size - 1, bank)
    bank.examples[t].move = move
    bank.examples[t].size = bank.scratch.size[0]
    at = t * ROWS
    # Number by number: for whole rows numba compiles the words of errors, too, which takes seconds.
    for d in range(bank.rows.shape[1]):
        for k in range(DIRECTIONS):
            bank.rows[at + k, d] = bank.scratch.directions[k, d]
        bank.rows[at + DIRECTIONS, d] = bank.scratch.box[d]
        bank.rows[at + DIRECTIONS + 1, d] = bank.scratch.shares[d]
        bank.rows[at + DIRECTIONS + 2, d] = bank.scratch.stance[d]


@entry_point
def compare_with_all(store, poses, path, costs, postures):
    """Compare an example with each of those in a store.

    Args:
        store: See `make_store`.
        poses: (n, D) m of the example; see `example_poses`.
        path: (n,) m; see `path_of`.
        costs: (T,) float64, gets what it costs to take the example for each.
        postures: (T,) float64, gets the cosine of the two mean postures.
    """
    bank = open_store(store)
    scratch, rows = bank.scratch, bank.rows
    describe(poses, path, 0, path.size - 1, bank)
    for t in range(bank.examples.size):
        at = t * ROWS
        factor = correction(scratch, rows[at + DIRECTIONS], rows[at + DIRECTIONS + 1], bank.examples[t].size)
        factor *= strangeness(scratch, rows[at + DIRECTIONS + 2])
        costs[t] = factor * warped(scratch, rows[at : at + DIRECTIONS], NEVER)
        postures[t] = line_product(scratch.stance, rows[at + DIRECTIONS + 2])


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


def _joint_records(places: Sequence[Pair], streamed: Skeleton) -> NDArray[np.void]:
    records = np.zeros(len(places), JOINT)
    limbs = list(limbs_of(streamed).values())
    for k, place in enumerate(places):
        limb = next((i for i, joints in enumerate(limbs) if place.one in joints and k > 0), -1)
        records[k] = (place.one, place.other, limb)
    return records
