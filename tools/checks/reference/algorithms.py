"""The paper's algorithms on whole arrays, line by line: the oracle that every faster path is tested against.

Nothing here is quick or incremental; it is meant to be read with the paper. The algorithms themselves are printed in
`splitter.pxi` (1 and 2) and `remerging.pxi` (3).
"""

from collections.abc import Callable

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import TIME_ROUNDING
from mossar_stream.events import KeyFrameKind


class Decision(msgspec.Struct, frozen=True):
    """One row of the paper's Table 1.

    Args:
        t: Frame.
        candidate: The candidate after the decision, None if there is none.
        decision: The decision.
        reason: Its reason.
    """

    t: int
    candidate: int | None
    decision: str
    reason: str


class Splitting(msgspec.Struct, frozen=True):
    """Result of Algorithm 2.

    Args:
        key_frames: Frames in the order of time.
        kinds: Kind of each.
        ceiling: (F,) Ceiling of Algorithm 1.
        floor: (F,) Floor of Algorithm 1.
        log: The decisions, as in Table 1.
    """

    key_frames: list[int]
    kinds: list[KeyFrameKind]
    ceiling: NDArray[np.float64]
    floor: NDArray[np.float64]
    log: list[Decision]


def localise(positions: NDArray[np.float64], root: int) -> NDArray[np.float64]:
    """Return positions relative to the body centre (paper 3.1.1, localisation).

    Args:
        positions: (n, J, 3) m.
        root: Index of the root, -1 for the centroid.

    Returns:
        (n, J, 3) m.
    """
    center = positions[:, root : root + 1] if root >= 0 else positions.mean(axis=1, keepdims=True)
    return positions - center


def velocity_curve(
    displacements: NDArray[np.float64],
    times: NDArray[np.float64],
    window: float,
    smoothing_window: int = 1,
) -> NDArray[np.float64]:
    """Return the velocity at every frame of a recording: equation 1, summed over the joints.

    This is the plain form that the streaming one is tested against.

    Args:
        displacements: (n,) m, path of all joints since the frame before; 0 for the first frame.
        times: (n,) s, increasing.
        window: Trailing window, s.
        smoothing_window: Length of the moving average, frames.

    Returns:
        (n,) m.
    """
    curve = np.empty(len(displacements))
    for t, now in enumerate(times):
        first = np.searchsorted(times, now - (window - TIME_ROUNDING), side="right")
        curve[t] = displacements[first : t + 1].sum()
    return np.array([curve[max(0, t + 1 - smoothing_window) : t + 1].mean() for t in range(len(curve))])


def envelope(V: NDArray[np.float64], sig_threshold: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return Ceiling and Floor for every frame (Algorithm 1, from the values of Algorithm 2, lines 4 and 5).

    Args:
        V: (F,) normalised velocity.
        sig_threshold: θ, sigThre.

    Returns:
        Two (F,) arrays.
    """
    ceiling, floor = np.empty(len(V)), np.empty(len(V))
    last_ceiling = last_floor = sig_threshold
    for t, value in enumerate(V):
        if value > last_ceiling:  # line 2
            last_ceiling, last_floor = value, max(value - sig_threshold, sig_threshold)
        elif value < last_floor:  # line 5
            last_floor, last_ceiling = max(value, sig_threshold), min(value + sig_threshold, last_ceiling)
        ceiling[t], floor[t] = last_ceiling, last_floor
    return ceiling, floor


def generate_key_frames(V: NDArray[np.float64], sig_threshold: float) -> Splitting:
    """Return the list of key frames (Algorithm 2) with a log in the form of Table 1.

    Where the paper is silent: V = θ counts as resting; a crossing frame is not tested as an extremum; the
    candidate is forgotten at every crossing; a plateau is one extremum at its first frame; the first frame and a
    plateau that lasts to the end are none.

    Args:
        V: (F,) normalised velocity.
        sig_threshold: θ, sigThre.
    """
    V = np.asarray(V, dtype=np.float64)
    ceiling, floor = envelope(V, sig_threshold)
    extrema = _extrema(V)
    found: list[tuple[int, KeyFrameKind]] = []  # line 2, List
    log: list[Decision] = []
    c: int | None = None  # line 3
    for t in range(len(V)):  # line 7
        if t > 0 and (V[t] > sig_threshold) != (V[t - 1] > sig_threshold):
            found.append((t, "onset" if V[t] > sig_threshold else "offset"))  # lines 9 and 10
            c = None
            log.append(Decision(t, c, "end of process", "cross sigThre"))
        elif V[t] > sig_threshold and extrema[t] < 0:  # lines 11 and 12
            if V[t] != floor[t]:
                log.append(Decision(t, c, "ignore the minimum", "insignificant"))
            elif c is None or V[t] < V[c]:  # lines 13 and 14
                verb = "promote the minimum to" if c is None else "replace"
                c = t
                log.append(
                    Decision(t, c, f"{verb} the candidate", "significant" if verb != "replace" else "lower")
                )
            else:
                log.append(Decision(t, c, "ignore the minimum", "not lower than the candidate"))
        elif V[t] > sig_threshold and extrema[t] > 0:  # lines 11 and 16
            if c is None:
                log.append(Decision(t, c, "ignore the maximum", "no candidate"))
            elif V[t] != ceiling[t]:
                log.append(Decision(t, c, "ignore the maximum", "insignificant"))
            else:
                found.append((c, "minimum"))  # lines 17 to 19
                c = None
                log.append(Decision(t, c, "accept the candidate", "a significant maximum found"))
    found.sort()
    return Splitting([frame for frame, _ in found], [kind for _, kind in found], ceiling, floor, log)


def _extrema(V: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return -1 at local minima, 1 at local maxima, 0 elsewhere; a plateau counts at its first frame."""
    signs = np.zeros(len(V), dtype=np.int64)
    for t in range(1, len(V) - 1):
        if V[t] == V[t - 1]:
            continue
        later = V[t + 1 :][V[t + 1 :] != V[t]]
        if len(later) and (V[t - 1] > V[t]) == (later[0] > V[t]):
            signs[t] = -1 if later[0] > V[t] else 1
    return signs


def remerge(
    key_frames: list[int],
    first: int,
    last: int,
    cost: Callable[[int, int, int], float],
) -> list[tuple[int, float]]:
    """Return the order in which key frames are removed, each with its strength (Algorithm 3).

    The printed loop bounds are off by one: here the list is k1 … kK without the first and the last frame, and
    the loop runs until it is empty, for any α and β to be applied afterwards. On ties the earliest key frame is
    removed. A strength is the cost of the merge, made monotone along the run.

    Args:
        key_frames: Key frames of Algorithm 2, increasing.
        first: First frame of the recording.
        last: Frame after its last.
        cost: Given (a, k, b), how unlike the segments a … k and k … b are; the paper's -Similarity.
    """
    kept = list(key_frames)  # line 2, List
    removed: list[tuple[int, float]] = []
    strength = 0.0
    while kept:  # line 3
        bounds = [first, *kept, last]
        costs = [cost(*bounds[i : i + 3]) for i in range(len(kept))]  # lines 8 and 9
        x = costs.index(min(costs))  # lines 10 to 12
        strength = max(strength, costs[x])
        removed.append((kept.pop(x), strength))  # line 17
    return removed
