"""Similarity: the small protocol that lets one remerge work with any measure, and the measures there are.

A measure is a module with

    add_frame(params, slot, body, pose, joints, time, weight, moving)
                                                  one frame into a summary, or into sums in the body that wait
    pour(params, slot, body, lanes)               the sums that wait into the summary
    add_pose(params, slot, pose, joints, time, weight)
                                                  its pose alone, in or out (weight < 0)
    merge_into(params, target, other)             two neighbours into one summary
    close(params, slot)                           what is kept about a whole segment
    strength(params, left, right, both)           at which the key frame between them falls, >= 0
    parting(params, left, right, both)            the same where `both` is the summary of both already
    similarity(params, cost, left, right)         in 0..1, for people to read; cost is strength, and the summaries
                                                  need not be closed

all compiled, on summaries as described in `summary.py`; in plain Python `slot_size(params)`,
`takes_pose(params)`, whether `add_frame` looks at the pose as one array, and `are_sound(params, slots)`, which looks
through summaries that come from outside; and a numpy record type for its parameters. The type of
the record that is passed selects the module when a kernel is compiled, so that using one measure does not
compile the others. A new measure is one such module and one row in `MEASURES`.
"""

from collections.abc import Callable
from types import ModuleType

import numpy as np
from numba import types
from numpy.typing import NDArray

from mossar_stream.jit.decorators import chosen_by_type
from mossar_stream.settings import ResolvedSettings, SimilarityName
from mossar_stream.similarity import likelihood
from mossar_stream.similarity.path_kernel import kernel as path_kernel

MEASURES: dict[SimilarityName, tuple[ModuleType, np.dtype[np.void]]] = {
    "evidence": (likelihood, likelihood.LIKELIHOOD),
    "likelihood": (likelihood, likelihood.LIKELIHOOD),
    "path_kernel": (path_kernel, path_kernel.PATH_KERNEL),
}


def make_params(settings: ResolvedSettings, joints: int, lanes: int, center: int) -> NDArray[np.void]:
    """Return the parameters of the measure that the settings name, as a one-element record array."""
    return MEASURES[settings.similarity][0].make_params(settings, joints, lanes, center)  # type: ignore[no-any-return]


def slot_size(settings: ResolvedSettings, params: NDArray[np.void]) -> int:
    """Return the length of a summary, float64 numbers."""
    return MEASURES[settings.similarity][0].slot_size(params)  # type: ignore[no-any-return]


def facts_at(settings: ResolvedSettings, params: NDArray[np.void]) -> int:
    """Return where the facts of evidence begin in a summary, 0 if there are none."""
    return int(params["facts"][0]) if settings.similarity == "evidence" else 0


def takes_pose(settings: ResolvedSettings, params: NDArray[np.void]) -> bool:
    """Tell whether `add_frame` looks at the pose as one array."""
    return MEASURES[settings.similarity][0].takes_pose(params)  # type: ignore[no-any-return]


def are_sound(settings: ResolvedSettings, params: NDArray[np.void], slots: NDArray[np.float64]) -> bool:
    """Tell whether summaries from outside can be worked on."""
    return MEASURES[settings.similarity][0].are_sound(params, slots)  # type: ignore[no-any-return]


def _chosen(params: types.Record, name: str) -> Callable[..., object]:
    for module, dtype in MEASURES.values():
        if set(dtype.names or ()) == set(params.fields):
            return getattr(module, name).py_func  # type: ignore[no-any-return]
    raise TypeError(f"no similarity measure has the parameters {sorted(params.fields)}")


def add_frame(params, slot, body, pose, joints, time, weight, moving):
    """Add one frame to a summary."""
    raise NotImplementedError


def add_pose(params, slot, pose, joints, time, weight):
    """Add a frame's pose to a summary, or take it out."""
    raise NotImplementedError


def pour(params, slot, body, lanes):
    """Add the sums that wait to a summary."""
    raise NotImplementedError


def merge_into(params, target, other):
    """Make a summary that of two neighbouring segments."""
    raise NotImplementedError


def close(params, slot):
    """Finish a summary."""
    raise NotImplementedError


def strength(params, left, right, both):
    """Return the strength of the key frame between two segments."""
    raise NotImplementedError


def parting(params, left, right, both):
    """Return the strength of the key frame between two segments whose common summary is known."""
    raise NotImplementedError


def similarity(params, cost, left, right):
    """Return the similarity of two segments, given the strength of the key frame between them."""
    raise NotImplementedError


@chosen_by_type(add_frame)
def _add_frame(params, slot, body, pose, joints, time, weight, moving):
    return _chosen(params, "add_frame")


@chosen_by_type(add_pose)
def _add_pose(params, slot, pose, joints, time, weight):
    return _chosen(params, "add_pose")


@chosen_by_type(pour)
def _pour(params, slot, body, lanes):
    return _chosen(params, "pour")


@chosen_by_type(merge_into)
def _merge_into(params, target, other):
    return _chosen(params, "merge_into")


@chosen_by_type(close)
def _close(params, slot):
    return _chosen(params, "close")


@chosen_by_type(strength)
def _strength(params, left, right, both):
    return _chosen(params, "strength")


@chosen_by_type(parting)
def _parting(params, left, right, both):
    return _chosen(params, "parting")


@chosen_by_type(similarity)
def _similarity(params, cost, left, right):
    return _chosen(params, "similarity")
