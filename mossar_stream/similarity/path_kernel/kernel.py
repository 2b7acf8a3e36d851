"""Path kernel: the paper's similarity of two segments, by all paths that their graphs share (paper 2.2.1).

    K = Σ over common simple paths of λ^length · Π vertex kernels · Π edge kernels

over the graphs of `graph.py`; a path is common if all its joints and edges are, a single joint is a path of length
0, and every undirected path counts once. The sum is exact (`path_sum.py`). The edge kernel is the smaller RRJRD
over the larger. Three forms, `kernel_form`:

    damped      vertex kernel 2⟨x,y⟩ / (|x|² + |y|²) on covariances with 1e-4 m² added on the diagonal, λ = 0.1;
                strength sqrt(T_a T_b / (T_a + T_b)) · (1 - K_ab / sqrt(K_aa K_bb)), T durations in s
    normalised  vertex kernel the cosine of the covariances, λ = 1; strength 1 - K_ab / sqrt(K_aa K_bb)
    sum         the same kernels; strength 1 / (1 + K_ab), as the paper compares its raw sums

Where the paper is silent: a joint whose covariance is below 1e-12 m² (a micrometre) does not move; two joints that
do not move are alike (1), one that moves and one that does not are not (0). Poses are weighted by the time they
stand for, and one that stands for no time is left out. A joint that was not seen yet is no vertex (0) and has no edge. A segment that lasts no time says nothing: its strength is
0, as with every measure.

A summary goes on, after the fields of `summary.py`, with what `make_params` lays out: sums, lows and highs of the
distances (`graph.py`), clock and bins of moments (`pyramid.py`), and of a closed segment the covariances of each
joint and the list of edges. TERM is K of the segment with itself.
"""

import numba
import numpy as np
from numba import float32, float64, void
from numpy.typing import NDArray

from mossar_stream.errors import SettingsError
from mossar_stream.jit.decorators import kernel
from mossar_stream.jit.linked import linked, publish
from mossar_stream.memory.joint_pages import PADDING, STEP_BEFORE, place
from mossar_stream.settings import KernelForm, ResolvedSettings
from mossar_stream.similarity.path_kernel.graph import (
    add_distances,
    merge_distances,
    rest_in_distances,
    set_edges,
)
from mossar_stream.similarity.path_kernel.path_sum import path_sum
from mossar_stream.similarity.path_kernel.pyramid import (
    BIN_RATE,
    LATEST,
    MOST_BINS,
    MOST_LEVELS,
    add_moments,
    bin_size,
    merge_moments,
    rest_in_moments,
    set_covariances,
)
from mossar_stream.similarity.summary import (
    DURATION,
    FRAMES,
    MOVING_FRAMES,
    PATH,
    SHORTEST_SEGMENT,
    TERM,
    Traits,
)

DAMPED, NORMALISED, SUM = range(3)
FORMS: tuple[KernelForm, ...] = ("damped", "normalised", "sum")
DECAY = 0.1  # λ of the damped form
DIAGONAL = 1e-4  # m², added to the variances in the damped form
AT_REST = 1e-12  # m², norm of a covariance below which a joint does not move

PATH_KERNEL = np.dtype(
    [
        ("joints", "i8"),
        ("padded_joints", "i8"),
        ("rows", "i8"),  # offsets k of the joint pairs (i, i + k mod J)
        ("pairs", "i8"),  # rows · padded joints
        ("edges", "i8"),  # N
        ("layers", "i8"),  # L
        ("form", "i8"),  # index into FORMS
        ("decay", "f8"),  # λ
        ("diagonal", "f8"),  # m²
        ("bins", "i8"),
        ("bin_size", "i8"),
        ("covariance", "i8"),  # length of a joint's covariances, 6 s
        ("distances_at", "i8"),  # where the parts of a summary begin
        ("clock_at", "i8"),
        ("bins_at", "i8"),
        ("covariances_at", "i8"),
        ("edges_at", "i8"),
        ("size", "i8"),  # of a summary
    ],
)
_PARAMS = numba.from_dtype(PATH_KERNEL)
_SUMMARY = float64[::1]


def make_params(settings: ResolvedSettings, joints: int, padded_joints: int, center: int) -> NDArray[np.void]:
    """Return the parameters of the path kernel as one record, for compiled code; make its kernels callable.

    Args:
        settings: Of the segmenter.
        joints: J.
        padded_joints: J, padded to a multiple of `PADDING`.
        center: Index of the root, -1 for the centroid; all measures get it.

    Raises:
        SettingsError: If the location step would take poses out of summaries, which hold minima and maxima.
    """
    if settings.location == "free":
        raise SettingsError(
            "setting location=free cannot be combined with similarity=path_kernel; use location=candidates or none"
        )
    damped = settings.kernel_form == "damped"
    p = np.zeros(1, PATH_KERNEL)[0]
    p["joints"], p["padded_joints"] = joints, padded_joints
    p["rows"] = joints // 2
    p["pairs"] = joints // 2 * padded_joints
    p["edges"], p["layers"], p["form"] = settings.edges, settings.layers, FORMS.index(settings.kernel_form)
    p["decay"], p["diagonal"] = (DECAY, DIAGONAL) if damped else (1.0, 0.0)
    p["bins"] = 1 if settings.layers == 1 else MOST_BINS
    p["bin_size"] = bin_size(padded_joints)
    p["covariance"] = 3 * settings.layers * (settings.layers + 1)
    parts = {
        "distances_at": 3 * p["pairs"],
        "clock_at": 3,
        "bins_at": p["bins"] * p["bin_size"],
        "covariances_at": joints * p["covariance"],
        "edges_at": 1 + 2 * settings.edges,
        "size": 0,
    }
    at = PATH + padded_joints
    for name, size in parts.items():
        p[name] = at
        at += -(-int(size) // PADDING) * PADDING
    for name in ("coarsen", "add", "merge", "kernel", "close", "strength"):
        publish(f"mossar.{name}")
    return np.array([p], PATH_KERNEL)


def slot_size(params: NDArray[np.void]) -> int:
    """Return the length of a summary, float64 numbers."""
    return int(params["size"][0])


def traits() -> Traits:
    """Return what frames and key frames must be like."""
    return Traits()


def takes_pose(_params: NDArray[np.void]) -> bool:
    """Tell whether `add_frame` looks at the pose as one array: it does."""
    return True


def are_sound(params: NDArray[np.void], slots: NDArray[np.float64]) -> bool:
    """Tell whether summaries from outside can be worked on: clocks and edges are used as indices.

    Args:
        params: Of `make_params`.
        slots: (n, size).
    """
    p = params[0]
    joints, padded, rows, most = (int(p[name]) for name in ("joints", "padded_joints", "rows", "edges"))
    clocks = slots[:, p["clock_at"] : p["clock_at"] + 3]
    counts, edges = slots[:, p["edges_at"]], slots[:, p["edges_at"] + 1 : p["edges_at"] + 1 + most]
    level, first, last = clocks.T
    with np.errstate(invalid="ignore", over="ignore"):
        farthest = LATEST * BIN_RATE / 2.0**level + 1.0
        sound = bool(
            ((level >= 0) & (level <= MOST_LEVELS) & (abs(first) <= farthest)).all()
            and ((last >= first) & (last < first + p["bins"]) & (abs(last) <= farthest)).all()
            and ((counts >= 0) & (counts <= most) & (counts == np.rint(counts))).all()
            and (clocks == np.rint(clocks)).all()
            and (p["bins"] > 1 or not clocks.any())  # with a single bin no clock runs
        )
    if not sound:
        return False
    legal = [
        r * padded + i for r in range(rows) for i in range(joints if 2 * (r + 1) < joints else joints // 2)
    ]
    return all(
        np.isin(own[: int(count)], legal).all() and (np.diff(own[: int(count)]) > 0).all()
        for own, count in zip(edges, counts, strict=True)
    )


@kernel
def write_features(params, summary, features):
    """Leave out what is known of a key frame: the path kernel asks for segments only."""


@kernel
def add_frame(params, summary, frame):
    """Add one frame to a summary.

    Args:
        params: Record of `make_params`.
        summary: Of the segment so far.
        frame: `SummaryFrame`.
    """
    summary[FRAMES] += 1.0
    summary[MOVING_FRAMES] += frame.moving
    for j in range(frame.joints):
        summary[PATH + j] += frame.body[place(j) + STEP_BEFORE]
    _add(params, summary, frame.pose, frame.time, frame.weight)


@kernel
def add_pose(params, summary, pose, joints, time, weight):
    """Add the pose alone: to the duration and the sums, not to frames and paths."""
    _add(params, summary, pose, time, weight)


@kernel
def add_joint(params, summary, pose, joints, j):
    """Let a joint have rest where it is for as long as a summary lasts."""
    if summary[DURATION] > 0.0:
        rest_in_moments(params, summary, pose, j)
        rest_in_distances(params, summary, pose, j)


@kernel
def flush_sums(params, summary, body, padded_joints):
    """Do nothing; every frame went into its summary at once."""


@kernel
def merge_into(params, target, other):
    """Make `target` the summary of both segments; neither order nor grouping matters beyond rounding."""
    _merge(params, target, other)


@kernel
def close(params, summary):
    """Set the covariances, the edges and, in TERM, the kernel of the segment with itself."""
    _close(params, summary)


@kernel
def strength(params, left, right, both):
    """Return the strength of the key frame between two closed neighbours, >= 0; `both` is left alone."""
    return _strength(params, left, right)


@kernel
def merge_cost(params, left, right, both):
    """Return the same; `both` is not looked at."""
    return _strength(params, left, right)


@kernel
def similarity(params, cost, left, right):
    """Return what the strength says of the kernel, in 0..1: K_ab / sqrt(K_aa K_bb), or K_ab / (1 + K_ab)."""
    scale = 1.0
    if params.form == DAMPED:
        total = left[DURATION] + right[DURATION]
        scale = np.sqrt(left[DURATION] * right[DURATION] / total) if total > 0.0 else 0.0
    return max(0.0, 1.0 - cost / scale) if scale > 0.0 else 1.0


@linked("mossar.add", void(_PARAMS, _SUMMARY, float32[:, ::1], float64, float64))
def _add(params, summary, pose, time, weight):
    if weight > 0.0:
        add_moments(params, summary, pose, time, weight)
        add_distances(params, summary, pose, weight)
        summary[DURATION] += weight


@linked("mossar.merge", void(_PARAMS, _SUMMARY, _SUMMARY))
def _merge(params, target, other):
    target[FRAMES] += other[FRAMES]
    target[MOVING_FRAMES] += other[MOVING_FRAMES]
    for j in range(params.joints):
        target[PATH + j] += other[PATH + j]
    if other[DURATION] == 0.0:
        return
    if target[DURATION] == 0.0:
        for d in range(PATH + params.padded_joints, params.size):
            target[d] = other[d]
    else:
        merge_moments(params, target, other)
        merge_distances(params, target, other)
    target[DURATION] += other[DURATION]


@linked("mossar.kernel", float64(_PARAMS, _SUMMARY, _SUMMARY))
def _kernel(params, left, right):
    """Return K of two closed segments."""
    weights = np.empty(params.joints)
    for j in range(params.joints):
        weights[j] = _vertex_kernel(params, left, right, params.covariances_at + j * params.covariance)
    edges = np.empty((params.edges, 2), np.int64)
    ratios = np.empty(params.edges)
    at = params.edges_at
    count = a = b = 0
    while a < left[at] and b < right[at]:
        pair = np.int64(left[at + 1 + a])
        other = np.int64(right[at + 1 + b])
        if pair == other:
            one, two = left[at + 1 + params.edges + a], right[at + 1 + params.edges + b]
            joint = pair % params.padded_joints
            edges[count, 0] = joint
            edges[count, 1] = (joint + pair // params.padded_joints + 1) % params.joints
            ratios[count] = params.decay * min(one, two) / max(one, two)
            count += 1
        a += 1 if pair <= other else 0
        b += 1 if other <= pair else 0
    return path_sum(weights, edges[:count], ratios[:count])


@kernel
def _vertex_kernel(params, left, right, at):
    """Compare the covariances of a joint; the products of covariances are never negative, but NaN where it is missing."""
    xx = yy = xy = 0.0
    for d in range(at, at + params.covariance):
        xx += left[d] * left[d]
        yy += right[d] * right[d]
        xy += left[d] * right[d]
    if not xy >= 0.0:
        return 0.0
    if params.form == DAMPED:
        return 2.0 * xy / (xx + yy)
    limit = AT_REST * AT_REST
    if xx <= limit or yy <= limit:
        return 1.0 if xx <= limit and yy <= limit else 0.0
    return max(0.0, xy / np.sqrt(xx * yy))


@linked("mossar.close", void(_PARAMS, _SUMMARY))
def _close(params, summary):
    summary[TERM] = 0.0
    if summary[DURATION] > SHORTEST_SEGMENT:
        set_covariances(params, summary)
        set_edges(params, summary)
        if params.form != SUM:
            summary[TERM] = _kernel(params, summary, summary)


@linked("mossar.strength", float64(_PARAMS, _SUMMARY, _SUMMARY))
def _strength(params, left, right):
    if not (left[DURATION] > SHORTEST_SEGMENT and right[DURATION] > SHORTEST_SEGMENT):
        return 0.0
    alike = _kernel(params, left, right)
    if params.form == SUM:
        return 1.0 / (1.0 + alike)
    most = np.sqrt(left[TERM] * right[TERM])
    unlike = max(0.0, 1.0 - alike / most) if most > 0.0 else 0.0  # nobody was seen
    if params.form == NORMALISED:
        return unlike
    return np.sqrt(left[DURATION] * right[DURATION] / (left[DURATION] + right[DURATION])) * unlike
