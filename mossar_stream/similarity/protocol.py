"""Similarity: the small protocol that lets one remerge work with any measure, and the measures there are.

A measure is a module with

    add_frame(params, summary, frame)             one frame into a summary, or into sums in the body that wait
    flush_sums(params, summary, body, padded_joints)
                                                  the sums that wait into the summary
    add_pose(params, summary, pose, joints, time, weight)
                                                  its pose alone, in or out (weight < 0)
    add_joint(params, summary, pose, joints, j)   a joint that was missing so far, as if it had rest where it is all along
    merge_into(params, target, other)             two neighbours into one summary
    close(params, summary)                        what is kept about a whole segment
    strength(params, left, right, both)           at which the key frame between them falls, >= 0
    merge_cost(params, left, right, both)         the same where `both` is the summary of both already
    similarity(params, cost, left, right)         in 0..1, for people to read; cost is strength, and the summaries
                                                  need not be closed
    write_features(params, summary, features)     `Features` of the key frame that ends a segment, if it asks for them

all kernels, on summaries as described in `summary.py`; in plain Python `slot_size(params)`, `takes_pose(params)`,
whether `add_frame` looks at the pose as one array, and `are_sound(params, slots)`, which looks through summaries that
come from outside; `traits()`, what frames and key frames must be like; and a numpy record type for its parameters. The
type of the record selects the module when a kernel is compiled, so that one measure does not compile the others. A new
measure is one such module and one row in `MEASURES`.
"""

from collections.abc import Callable
from types import ModuleType

import numpy as np
from numba import types
from numpy.typing import NDArray

from mossar_stream.jit.decorators import kernel
from mossar_stream.settings import ResolvedSettings, SimilarityName
from mossar_stream.similarity import evidence, likelihood
from mossar_stream.similarity.path_kernel import kernel as path_kernel
from mossar_stream.similarity.summary import DURATION, SHORTEST_SEGMENT, Traits

MEASURES: dict[SimilarityName, tuple[ModuleType, np.dtype[np.void]]] = {
    "evidence": (evidence, evidence.EVIDENCE),
    "likelihood": (likelihood, likelihood.LIKELIHOOD),
    "path_kernel": (path_kernel, path_kernel.PATH_KERNEL),
}


def make_params(settings: ResolvedSettings, joints: int, padded_joints: int, center: int) -> NDArray[np.void]:
    """Return the parameters of the measure that the settings name, as a one-element record array."""
    return MEASURES[settings.similarity][0].make_params(settings, joints, padded_joints, center)  # type: ignore[no-any-return]


def slot_size(settings: ResolvedSettings, params: NDArray[np.void]) -> int:
    """Return the length of a summary, float64 numbers."""
    return MEASURES[settings.similarity][0].slot_size(params)  # type: ignore[no-any-return]


def traits(settings: ResolvedSettings) -> Traits:
    """Return what frames and key frames must be like for the measure that the settings name."""
    return MEASURES[settings.similarity][0].traits()  # type: ignore[no-any-return]


def takes_pose(settings: ResolvedSettings, params: NDArray[np.void]) -> bool:
    """Tell whether `add_frame` looks at the pose as one array."""
    return MEASURES[settings.similarity][0].takes_pose(params)  # type: ignore[no-any-return]


def are_sound(settings: ResolvedSettings, params: NDArray[np.void], slots: NDArray[np.float64]) -> bool:
    """Tell whether summaries from outside can be worked on.

    Durations must be numbers of seconds, up to what is lost by rounding when poses are taken out: kernels compare
    costs to find the smallest one, and one that is NaN would never be found.

    Args:
        settings: Which measure.
        params: Of `make_params`.
        slots: (n, slot).
    """
    durations = slots[:, DURATION]
    if not (np.isfinite(durations) & (durations > -SHORTEST_SEGMENT)).all():
        return False
    return MEASURES[settings.similarity][0].are_sound(params, slots)  # type: ignore[no-any-return]


def _of_measure(name: str, params: types.Record, *_: types.Type) -> Callable[..., object]:
    """Return the kernel of this name of the measure whose parameters these are."""
    for module, dtype in MEASURES.values():
        if set(dtype.names or ()) == set(params.fields):
            return getattr(module, name).py_func  # type: ignore[no-any-return]
    raise TypeError(f"no similarity measure has the parameters {sorted(params.fields)}")


@kernel(chosen_by=_of_measure)
def add_frame(params, summary, frame):
    """Add one frame, a `SummaryFrame`, to a summary."""
    raise NotImplementedError


@kernel(chosen_by=_of_measure)
def add_pose(params, summary, pose, joints, time, weight):
    """Add a frame's pose to a summary, or take it out."""
    raise NotImplementedError


@kernel(chosen_by=_of_measure)
def add_joint(params, summary, pose, joints, j):
    """Add a joint that was missing so far to a summary."""
    raise NotImplementedError


@kernel(chosen_by=_of_measure)
def flush_sums(params, summary, body, padded_joints):
    """Add the sums that wait to a summary."""
    raise NotImplementedError


@kernel(chosen_by=_of_measure)
def merge_into(params, target, other):
    """Make a summary that of two neighbouring segments."""
    raise NotImplementedError


@kernel(chosen_by=_of_measure)
def close(params, summary):
    """Finish a summary."""
    raise NotImplementedError


@kernel(chosen_by=_of_measure)
def strength(params, left, right, both):
    """Return the strength of the key frame between two segments."""
    raise NotImplementedError


@kernel(chosen_by=_of_measure)
def merge_cost(params, left, right, both):
    """Return the strength of the key frame between two segments whose common summary is known."""
    raise NotImplementedError


@kernel(chosen_by=_of_measure)
def similarity(params, cost, left, right):
    """Return the similarity of two segments, given the strength of the key frame between them."""
    raise NotImplementedError


@kernel(chosen_by=_of_measure)
def write_features(params, summary, features):
    """Write what is known of a key frame into the summary of the segment that it ends."""
    raise NotImplementedError
