"""The parameters of the path kernel and the layout of its summaries; `kernel.pxi` has the measure."""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import BIN_RATE, LATEST, PADDING, PATH
from mossar_stream.errors import SettingsError
from mossar_stream.settings import KernelForm, ResolvedSettings
from mossar_stream.similarity.summary import Traits

FORMS: tuple[KernelForm, ...] = ("damped", "normalised", "sum")  # in the order of kernel.pxi
DECAY = 0.1  # λ of the damped form
DIAGONAL = 1e-4  # m², added to the variances in the damped form
MOST_BINS = 64
MOST_LEVELS = 48  # of doubling, after which a bin holds everything


def set_params(
    params: NDArray[np.void], settings: ResolvedSettings, joints: int, padded_joints: int, _center: int
) -> None:
    """Set the parameters, and lay out a summary.

    Args:
        params: (1,) record, zero.
        settings: Of the segmenter.
        joints: J.
        padded_joints: J, padded to a multiple of `PADDING`.

    Raises:
        SettingsError: If the location step would take poses out of summaries, which hold minima and maxima.
    """
    if settings.location == "free":
        raise SettingsError(
            "setting location=free cannot be combined with similarity=path_kernel; use location=candidates or none"
        )
    damped = settings.kernel_form == "damped"
    p = params[0]
    p["joints"], p["padded_joints"] = joints, padded_joints
    p["rows"] = joints // 2
    p["pairs"] = joints // 2 * padded_joints
    p["edges"], p["layers"], p["form"] = settings.edges, settings.layers, FORMS.index(settings.kernel_form)
    p["decay"], p["diagonal"] = (DECAY, DIAGONAL) if damped else (1.0, 0.0)
    p["bins"] = 1 if settings.layers == 1 else MOST_BINS
    p["bin_size"] = PADDING + 9 * padded_joints  # weight and padding, 3 means and 6 products per joint
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


def slot_size(params: NDArray[np.void]) -> int:
    """Return the length of a summary, float64 numbers."""
    return int(params["size"][0])


def traits() -> Traits:
    """Return the requirements on frames and key frames."""
    return Traits()


def takes_pose(_params: NDArray[np.void]) -> bool:
    """Return whether `add_frame` reads the pose as one array: it does."""
    return True


def are_sound(params: NDArray[np.void], slots: NDArray[np.float64]) -> bool:
    """Return whether summaries from outside are valid: clocks and edges are used as indices.

    Args:
        params: (1,) record.
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
