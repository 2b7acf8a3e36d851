"""Kinds: groups of unnamed examples that show the same move.

The recogniser's cost is computed for all pairs. Examples are joined by average linkage until the mean logarithm of the
cost between two groups is above `KINDS_APART`.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import compare_with_all
from mossar_stream.moves.bank import example_poses, make_store, path_of, store_of
from mossar_stream.moves.example import Example
from mossar_stream.moves.joints import shared_joints
from mossar_stream.moves.rules import USUAL, Facing
from mossar_stream.skeleton import Skeleton

KINDS_APART = -0.5  # natural logarithm of the mean cost between two kinds


def kinds_of(skeleton: Skeleton, examples: Sequence[Example], facing: Facing) -> list[list[int]]:
    """Return groups of examples that show the same move, the largest first, in each the most typical first.

    Args:
        skeleton: Of the examples.
        examples: Their names do not matter.
        facing: Whether it matters which way the body faced.
    """
    if not examples:
        return []
    costs = _costs(skeleton, examples, facing)
    groups = _joined(costs)
    ordered = [sorted(group, key=lambda i: float(costs[i, group].sum())) for group in groups]
    return sorted(ordered, key=lambda group: (-len(group), min(group)))


def described(skeleton: Skeleton, examples: Sequence[Example], facing: Facing) -> NDArray[np.uint8]:
    """Return a store of examples that movements of the same skeleton are compared with."""
    return make_store(skeleton, examples, {example.name: USUAL for example in examples}, skeleton, facing)


def costs_of(
    skeleton: Skeleton, store: NDArray[np.uint8], movement: Example
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the cost of a movement against each example of a store, and how alike the mean postures are (cosine).

    Args:
        skeleton: Of the examples and of the movement.
        store: See `described`.
        movement: From its onset to its offset.

    Returns:
        (n,) costs, of which the least is the likeliest, and (n,) cosines.
    """
    head = store_of(store)["head"][0]
    costs = np.zeros(int(head["examples"]))
    _, ours, _ = shared_joints(skeleton, skeleton)
    poses = example_poses(movement, len(skeleton), ours, int(head["numbers"]))
    postures = np.zeros(len(costs))
    compare_with_all(store, poses, path_of(poses), costs, postures)
    return costs, postures


def _costs(skeleton: Skeleton, examples: Sequence[Example], facing: Facing) -> NDArray[np.float64]:
    """Return (n, n) natural logarithms of the costs between examples, the mean of both directions."""
    store = described(skeleton, examples, facing)
    costs = np.array([costs_of(skeleton, store, example)[0] for example in examples])
    logs: NDArray[np.float64] = np.log(np.maximum(costs, np.finfo(np.float64).tiny))
    return (logs + logs.T) / 2


def _joined(costs: NDArray[np.float64]) -> list[list[int]]:
    """Return groups by average linkage."""
    groups = [[i] for i in range(len(costs))]
    between = costs.copy()
    np.fill_diagonal(between, np.inf)
    while len(groups) > 1:
        a, b = sorted(divmod(int(np.argmin(between)), len(groups)))
        if between[a, b] > KINDS_APART:
            break
        p, q = len(groups[a]), len(groups[b])
        between[a] = between[:, a] = (p * between[a] + q * between[b]) / (p + q)
        between[a, a] = np.inf
        between = np.delete(np.delete(between, b, axis=0), b, axis=1)
        groups[a] += groups.pop(b)
    return groups
