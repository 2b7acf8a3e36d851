"""The bank: all examples described for the joints of one stream, as the recogniser compares them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.decorators import entry_point
from mossar_stream.moves.example import Example, smoothed
from mossar_stream.moves.joints import Pair, shared_joints
from mossar_stream.moves.lanes import padded
from mossar_stream.moves.limbs import limbs_of
from mossar_stream.moves.measure import DIRECTIONS, POINTS, Description, describe
from mossar_stream.moves.recogniser import EXAMPLE, ROWS, Bank
from mossar_stream.moves.track import JOINT, SMOOTHED
from mossar_stream.skeleton import Skeleton


def make_bank(shown: Skeleton, examples: Sequence[Example], names: Sequence[str], streamed: Skeleton) -> Bank:
    """Describe examples for a stream.

    Args:
        shown: Skeleton of the examples.
        examples: All of them.
        names: Of the moves, in the order in which they are numbered.
        streamed: Skeleton of the stream.

    Raises:
        FrameError: If the stream lacks joints that the examples need.
    """
    _, ours, theirs = shared_joints(shown, streamed)
    room = make_description(len(ours))
    records = np.zeros(len(examples), EXAMPLE)
    rows = np.zeros((len(examples) * ROWS, room.box.size), np.float32)
    for t, example in enumerate(examples):
        poses = example_poses(example, len(shown), ours, room.box.size)
        describe_whole(poses, _path(poses), len(ours), room)
        records[t] = (names.index(example.name), room.size[0], 0.0)
        rows[t * ROWS : t * ROWS + DIRECTIONS] = room.directions
        rows[t * ROWS + DIRECTIONS] = room.box
        rows[t * ROWS + DIRECTIONS + 1] = room.shares
    return Bank(_joint_records(theirs, streamed), records, rows, room)


@entry_point
def describe_whole(poses, path, joints, found):
    """Describe all of an example; see `measure.describe`."""
    describe(poses, path, 0, path.size - 1, joints, found)


def make_description(joints: int) -> Description:
    """Return room for a description of so many joints."""
    numbers = padded(3 * joints)

    def lines(*shape: int) -> NDArray[np.float32]:
        return np.zeros(shape, np.float32)

    return Description(
        lines(POINTS, numbers),
        lines(DIRECTIONS, numbers),
        lines(numbers),
        lines(numbers),
        lines(1),
        lines(numbers),
        lines(2, DIRECTIONS + 1),
    )


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


def _path(poses: NDArray[np.float32]) -> NDArray[np.float64]:
    steps = np.linalg.norm(np.diff(poses.astype(np.float64), axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _joint_records(places: Sequence[Pair], streamed: Skeleton) -> NDArray[np.void]:
    records = np.zeros(len(places), JOINT)
    limbs = list(limbs_of(streamed).values())
    for k, place in enumerate(places):
        limb = next((i for i, joints in enumerate(limbs) if place.one in joints and k > 0), -1)
        records[k] = (place.one, place.other, limb)
    return records
