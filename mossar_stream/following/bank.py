"""The bank: followed examples as directions of bones, phase by phase, for the joints of one stream."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import (
    CAP,
    MOST_PHASES,
    PERIOD,
    RECORDS,
    follow_bank_bytes,
    follow_bank_parts,
    follow_example_parts,
    mean_heading,
    place_follow_examples,
)
from mossar_stream.errors import MovesError
from mossar_stream.following.bones import NOWHERE, Bones, shared_bones
from mossar_stream.moves.example import Example
from mossar_stream.moves.joints import Pair
from mossar_stream.moves.moves import Moves
from mossar_stream.moves.parts import parts_of
from mossar_stream.moves.points import UPWARDS
from mossar_stream.moves.rules import Facing
from mossar_stream.settings import Up
from mossar_stream.skeleton import Skeleton

FOLLOW_HEAD = RECORDS["FollowHead"]
LONGEST_EXAMPLE = 60.0  # s, of a movement that is followed
SHORTEST_EXAMPLE = 4  # phases
LEAST_MOVED = 1e-4  # mean square of the chord by which an example moves
SPREAD_PHASES = 32  # at which examples of one move are compared
LEAST_SPREAD = 0.05  # chord: 3 degrees, which any two performances differ by
SMALLEST_BONE = 1e-6  # m, of a bone


def make_bank(moves: Moves, names: Sequence[str], streamed: Skeleton, up: Up) -> NDArray[np.uint8]:
    """Describe the examples of followed moves for a stream.

    Args:
        moves: Whose examples and mirror images there are; those of others than `names` are left out.
        names: Of the followed moves, in the order in which they are numbered.
        streamed: Skeleton of the stream.
        up: The axis that points upwards; `auto` is y.

    Returns:
        Bytes: `FOLLOW_HEAD`, then the parts of `bank_of` and `example_of`.

    Raises:
        FrameError: If the stream lacks joints that the examples need.
        MovesError: If an example is too long to be followed, or nothing can be compared.
    """
    shown, facing = moves.skeleton, moves.facing
    examples = moves.examples_and_images(up)
    bones = shared_bones(shown, streamed)
    if not bones.bones:
        raise MovesError("nothing can be followed: the examples have no bone that the stream has, too")
    chosen = [place for place, example in enumerate(examples) if example.name in names]
    chosen.sort(key=lambda place: names.index(examples[place].name))
    followed = [examples[place] for place in chosen]
    phases = [_phases_of(example, shown, bones, up, facing) for example in followed]
    strides = sorted({stride for stride, _ in phases})
    counts = np.array([len(directions) for _, directions in phases], np.int64)
    store = np.zeros(follow_bank_bytes(len(bones.streamed), len(bones.bones), counts), np.uint8)
    axis, sign = UPWARDS[up]
    girdles = bones.girdles if facing == "any" else (NOWHERE,) * 4
    store[: FOLLOW_HEAD.itemsize].view(FOLLOW_HEAD)[0] = (
        len(bones.streamed), len(bones.bones), len(followed), len(names), len(bones.limbs), girdles, axis, sign,
        len(strides), 0, 0, 0,
    )  # fmt: skip
    records = bank_of(store)["examples"]
    records["phases"] = counts
    place_follow_examples(store)
    bank = bank_of(store)
    bank["points"][:] = [tuple(pair) for pair in bones.streamed]
    bank["bones"][:] = [tuple(bone) for bone in bones.bones]
    if followed:
        bank["first_pose"][:] = _first_pose(followed[0], shown, bones, up)
    for t, (example, (stride, directions)) in enumerate(zip(followed, phases, strict=True)):
        mean = directions.mean(axis=0)
        still = ((directions - mean) ** 2).sum(axis=2)
        farthest = ((directions - directions[0]) ** 2).sum(axis=2).mean(axis=1).max()
        if farthest < LEAST_MOVED:
            raise MovesError(f"an example of {example.name!r} cannot be followed: no bone turns in it")
        record = records[t]
        record["move"], record["stride"] = names.index(example.name), stride
        record["ring"], record["farthest"] = strides.index(stride), farthest
        record["still"], record["dear"] = still.mean(), np.minimum(still, CAP).mean()
        own = example_of(store, t)
        own["directions"][:, :, : len(directions)] = directions.transpose(1, 2, 0)
        own["means"][:] = mean
    sides = [(examples[place].name, place >= len(moves)) for place in chosen]
    weights = {
        side: _weights(
            [directions for one, (_, directions) in zip(sides, phases, strict=True) if one == side]
        )
        for side in dict.fromkeys(sides)
    }
    for t, side in enumerate(sides):
        bank["weights"][t] = weights[side]
    return store


def _weights(examples: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return how much each bone counts in the deviation: the less, the more examples of a move differ among themselves.

    Args:
        examples: (n, B, 3) directions of each of a move, or of their mirror images.

    Returns:
        (B,), with the sum 1.
    """
    lines = np.linspace(0, 1, SPREAD_PHASES)
    same = np.array([own[np.rint(lines * (len(own) - 1)).astype(int)] for own in examples])
    spread = np.sqrt(((same - same.mean(axis=0)) ** 2).sum(axis=3).mean(axis=(0, 1)))
    weights: NDArray[np.float64] = 1.0 / (spread + LEAST_SPREAD)
    return np.asarray(weights / weights.sum())


def _phases_of(
    example: Example, shown: Skeleton, bones: Bones, up: Up, facing: Facing
) -> tuple[int, NDArray[np.float64]]:
    """Return how many samples make a phase, and the directions of bones at each phase, (n, B, 3)."""
    positions, rate = example.followed(len(shown), shown.root)
    seconds = (len(positions) - 1) / rate
    if seconds > LONGEST_EXAMPLE:
        raise MovesError(
            f"the movement in an example of {example.name!r} takes {seconds:.0f} s; what is followed takes at most {LONGEST_EXAMPLE:.0f} s"
        )
    stride = max(1, int(np.ceil(seconds / PERIOD / (MOST_PHASES - 1))))
    count = max(SHORTEST_EXAMPLE, round(seconds / (PERIOD * stride)) + 1)
    places = np.linspace(0, len(positions) - 1, count)
    below = np.minimum(places.astype(np.int64), len(positions) - 2)
    share = (places - below).reshape(-1, 1, 1)
    points = points_of(positions.astype(np.float64), bones.shown, up)
    cosine, sine = (1.0, 0.0)
    if facing == "any" and bones.girdles[0] >= 0:
        cosine, sine = mean_heading(
            np.ascontiguousarray(points, np.float32), np.array(bones.girdles, np.int64)
        )
    return stride, directions_of(points[below] * (1 - share) + points[below + 1] * share, bones, cosine, sine)


def _first_pose(example: Example, shown: Skeleton, bones: Bones, up: Up) -> NDArray[np.float64]:
    """Return the points of an example's first frame relative to the centre, (K, 3) m."""
    positions, _ = example.followed(len(shown), shown.root)
    points = points_of(positions[:1].astype(np.float64), bones.shown, up)[0]
    return np.asarray(points - points[0])


def points_of(positions: NDArray[np.float64], pairs: Sequence[Pair], up: Up) -> NDArray[np.float64]:
    """Return the points of (n, J, 3) positions, y upwards: (n, K, 3) m."""
    mean = positions.mean(axis=1)
    lines = [(positions[:, one] + positions[:, other]) / 2 if one >= 0 else mean for one, other in pairs]
    axis, sign = UPWARDS[up]
    turned = np.stack(lines, axis=1)[:, :, [(axis + 2) % 3, axis, (axis + 1) % 3]]
    return np.asarray(turned * np.array([sign, sign, 1.0]))


def directions_of(
    points: NDArray[np.float64], bones: Bones, cosine: float, sine: float
) -> NDArray[np.float64]:
    """Return the directions of bones of a body with a heading, as if it faced +z.

    Args:
        points: (n, K, 3) m, y upwards.
        bones: Which there are.
        cosine: Of the heading.
        sine: The same.

    Returns:
        (n, B, 3).
    """
    begins, ends = [bone.begin for bone in bones.bones], [bone.end for bone in bones.bones]
    found = points[:, ends] - points[:, begins]
    found /= np.maximum(np.linalg.norm(found, axis=2, keepdims=True), SMALLEST_BONE)
    turn = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
    return np.asarray(found @ turn)


def bank_of(store: NDArray[np.uint8]) -> dict[str, NDArray[Any]]:
    """Return views of the parts of a bank: `head`, `points`, `bones`, `examples`, `first_pose`, `weights`."""
    return parts_of(store, follow_bank_parts(store))


def example_of(store: NDArray[np.uint8], t: int) -> dict[str, NDArray[Any]]:
    """Return views of the parts of a bank for example t: `directions`, (B, 3, padded phases), and `means`, (B, 3)."""
    return parts_of(store, follow_example_parts(store, t))


def extents_of(store: NDArray[np.uint8]) -> list[NDArray[np.float32]]:
    """Return the extent of each bone's directions in each example of a bank, (B, 3)."""
    found = []
    for t, example in enumerate(bank_of(store)["examples"]):
        directions = example_of(store, t)["directions"][:, :, : int(example["phases"])]
        found.append(directions.max(axis=2) - directions.min(axis=2))
    return found
