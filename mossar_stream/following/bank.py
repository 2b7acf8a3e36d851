"""The bank: followed examples as directions of bones, phase by phase, for the joints of one stream."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_stream.errors import MovesError
from mossar_stream.following.bones import Bones, shared_bones
from mossar_stream.following.layout import (
    BONE,
    BONE_BYTES,
    EXAMPLE,
    EXAMPLE_BYTES,
    HEAD,
    HEAD_BYTES,
    LANES,
    MOST_PHASES,
    PERIOD,
    POINT,
    POINT_BYTES,
    example_floats,
    example_memory,
    head_memory,
)
from mossar_stream.moves.example import Example
from mossar_stream.moves.joints import Pair
from mossar_stream.settings import Up
from mossar_stream.skeleton import Skeleton

LONGEST = 60.0  # s, of an example that is followed
SHORTEST = 4  # phases
UPWARDS = {"auto": (1, 1.0), "x": (0, 1.0), "y": (1, 1.0), "z": (2, 1.0)} | {
    f"-{axis}": (place, -1.0) for place, axis in enumerate("xyz")
}
DEAREST = 0.2  # mean square of the chord at which nothing is followed any more: 26 degrees
MOST_OF_STILL = 0.6  # of what the best single pose would cost; a performer who stands still makes no move
SMALLEST = 1e-6  # m, of a bone


def make_bank(
    shown: Skeleton, examples: Sequence[Example], names: Sequence[str], streamed: Skeleton, up: Up
) -> NDArray[np.uint8]:
    """Describe the examples of followed moves for a stream.

    Args:
        shown: Skeleton of the examples.
        examples: Of any moves; those of others than `names` are left out.
        names: Of the followed moves, in the order in which they are numbered.
        streamed: Skeleton of the stream.
        up: The axis that points upwards; `auto` is y.

    Returns:
        Bytes: `HEAD`, then points, bones, examples, and their directions.

    Raises:
        FrameError: If the stream lacks joints that the examples need.
        MovesError: If an example is too long to be followed, or nothing can be compared.
    """
    bones = shared_bones(shown, streamed)
    if not bones.bones:
        raise MovesError("nothing can be followed: the examples have no bone that the stream has, too")
    axis, sign = UPWARDS[up]
    lanes = -(-len(bones.bones) // LANES) * LANES
    followed = sorted((e for e in examples if e.name in names), key=lambda e: names.index(e.name))
    phases = [_phases_of(example, shown, bones, axis, sign, lanes) for example in followed]
    store = np.zeros(_bytes_of(bones, lanes, phases), np.uint8)
    store[:HEAD_BYTES].view(HEAD)[0] = (
        len(bones.streamed), len(bones.bones), lanes, len(followed), len(names), bones.left, bones.right, axis, sign,
        max((stride for stride, _ in phases), default=1),
    )  # fmt: skip
    at = HEAD_BYTES
    for kind, rows in ((POINT, bones.streamed), (BONE, bones.bones)):
        size = len(rows) * kind.itemsize
        store[at : at + size].view(kind)[:] = [tuple(row) for row in rows]
        at += size
    records = store[at : at + len(followed) * EXAMPLE_BYTES].view(EXAMPLE)
    floats = store[at + records.nbytes :].view(np.float32)
    place, memory = 0, head_memory(len(bones.streamed), lanes, len(names))
    for t, (example, (stride, directions)) in enumerate(zip(followed, phases, strict=True)):
        count = len(directions)
        dearest = min(DEAREST, MOST_OF_STILL * _cost_of_still(directions, len(bones.bones)))
        records[t] = names.index(example.name), count, stride, place, dearest, memory
        floats[place : place + directions.size] = directions.ravel()
        place += example_floats(count, lanes)
        memory += example_memory(count, lanes)
    return store


def _bytes_of(bones: Bones, lanes: int, phases: Sequence[tuple[int, NDArray[np.float32]]]) -> int:
    fixed = HEAD_BYTES + len(bones.streamed) * POINT_BYTES + len(bones.bones) * BONE_BYTES
    return fixed + len(phases) * EXAMPLE_BYTES + 4 * sum(example_floats(len(d), lanes) for _, d in phases)


def _phases_of(
    example: Example, shown: Skeleton, bones: Bones, axis: int, sign: float, lanes: int
) -> tuple[int, NDArray[np.float32]]:
    """Return how many samples make a phase, and the directions of bones at each phase, (n, 3, lanes)."""
    positions, rate = example.shown(len(shown))
    seconds = (len(positions) - 1) / rate
    if seconds > LONGEST:
        raise MovesError(
            f"an example of {example.name!r} takes {seconds:.0f} s; what is followed takes at most {LONGEST:.0f} s"
        )
    stride = max(1, int(np.ceil(seconds / PERIOD / MOST_PHASES)))
    count = max(SHORTEST, round(seconds / (PERIOD * stride)) + 1)
    places = np.linspace(0, len(positions) - 1, count)
    below = np.minimum(places.astype(np.int64), len(positions) - 2)
    share = (places - below).reshape(-1, 1, 1)
    points = _points(positions.astype(np.float64), bones.shown)
    found = directions_of(points[below] * (1 - share) + points[below + 1] * share, bones, axis, sign)
    padded = np.zeros((count, 3, lanes), np.float32)
    padded[:, :, : len(bones.bones)] = found
    return stride, padded


def _cost_of_still(directions: NDArray[np.float32], bones: int) -> float:
    """Return the mean square of the chord between an example and the one pose that is nearest to all of it."""
    return float(directions[:, :, :bones].var(axis=0).sum(axis=0).mean())


def _points(positions: NDArray[np.float64], pairs: Sequence[Pair]) -> NDArray[np.float64]:
    mean = positions.mean(axis=1)
    lines = [(positions[:, one] + positions[:, other]) / 2 if one >= 0 else mean for one, other in pairs]
    return np.stack(lines, axis=1)


def directions_of(points: NDArray[np.float64], bones: Bones, axis: int, sign: float) -> NDArray[np.float64]:
    """Return the directions of bones, turned so that the hips lie along the first axis and the second points upwards.

    Args:
        points: (n, K, 3) m.
        bones: Which there are.
        axis: That points upwards.
        sign: 1, or -1 if it points downwards.

    Returns:
        (n, 3, B).
    """
    turned = points[:, :, [(axis + 2) % 3, axis, (axis + 1) % 3]] * np.array([sign, sign, 1.0])
    begins, ends = [bone.begin for bone in bones.bones], [bone.end for bone in bones.bones]
    found = turned[:, ends] - turned[:, begins]
    found /= np.maximum(np.linalg.norm(found, axis=2, keepdims=True), SMALLEST)
    if bones.left >= 0:
        across = (turned[:, bones.left] - turned[:, bones.right]).mean(axis=0)
        width = max(float(np.hypot(across[0], across[2])), SMALLEST)
        cosine, sine = across[0] / width, across[2] / width
        found = found @ np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
    directions: NDArray[np.float64] = found.transpose(0, 2, 1)
    return directions


def examples_of(store: NDArray[np.uint8]) -> NDArray[np.void]:
    """Return the records of the examples of a bank, (T,) EXAMPLE."""
    begin, count = _examples_at(store)
    return store[begin : begin + count * EXAMPLE_BYTES].view(EXAMPLE)


def rows_of(store: NDArray[np.uint8]) -> list[NDArray[np.float32]]:
    """Return the directions of each example of a bank, (n, 3, lanes)."""
    begin, count = _examples_at(store)
    floats = store[begin + count * EXAMPLE_BYTES :].view(np.float32)
    lanes = int(store[:HEAD_BYTES].view(HEAD)[0]["lanes"])
    found = []
    for example in examples_of(store):
        size = example_floats(int(example["phases"]), lanes)
        found.append(floats[int(example["rows"]) :][:size].reshape(-1, 3, lanes))
    return found


def _examples_at(store: NDArray[np.uint8]) -> tuple[int, int]:
    head = store[:HEAD_BYTES].view(HEAD)[0]
    begin = HEAD_BYTES + int(head["points"]) * POINT_BYTES + int(head["bones"]) * BONE_BYTES
    return begin, int(head["examples"])
