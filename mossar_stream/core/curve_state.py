"""State: the velocity curve at the last frame, for people who watch."""

import warnings

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import EARLIER, EARLIER_IN_NOISE, LINES, MARGIN, PAGE, POSE_X
from mossar_stream.core.plan import Plan
from mossar_stream.core.row import records, region


class CurveState(msgspec.Struct, frozen=True):
    """The curve at one frame, as shares of the range.

    Args:
        frame: Number of the frame.
        time: s.
        reported_time: s, of a key frame at this frame. With evidence it is a little earlier, since
            smoothing delays the velocity.
        value: Velocity.
        ceiling: Ceiling of Algorithm 1.
        floor: Floor of Algorithm 1.
        threshold: θ.
        scale: Path of a velocity of 1, m over the window summed over the joints; 1 with a fixed range.
        moving: Whether this is a moving period.
        pace: Tempo factor that merge costs were divided by when key frames were ranked last.
        own_time: The performer's own time τ, s, in which the extent of the movements is covered at the usual speed; None
            where the level does not measure it.
        pose: (J, 3) m relative to the centre.
    """

    frame: int
    time: float
    reported_time: float
    value: float
    ceiling: float
    floor: float
    threshold: float
    scale: float
    moving: bool
    pace: float
    own_time: float | None
    pose: NDArray[np.float32]

    @property
    def told(self) -> float:
        """The former name of `reported_time`; the next release does not have it."""
        warnings.warn("told is called reported_time now; the next release has no told", DeprecationWarning, 2)
        return self.reported_time


def curve_state(row: NDArray[np.uint8], plan: Plan) -> CurveState:
    """Return the curve at the last frame of a row."""
    state = records(row)
    curve = state["curve"]
    fixed = plan.settings.range == "fixed"
    scale = (
        1.0
        if fixed
        else max(
            float(value)
            for value in (state["range"]["largest"], state["plan"]["range_floor"], state["noise"]["floor"])
        )
    )
    per = 1.0 / scale if scale > 0 else 0.0
    lines = region(row, "body").reshape(-1, LINES, PAGE).transpose(1, 0, 2).reshape(LINES, -1)
    time = float(state["clock"]["time"])
    pose = lines[POSE_X // PAGE : POSE_X // PAGE + 3, : plan.record["joints"][0]].T
    return CurveState(
        frame=int(state["clock"]["used_frame"]),
        time=time,
        reported_time=_reported_time(row) if plan.traits.has_features else time,
        value=float(curve["value"]) * per,
        ceiling=float(curve["ceiling"]) * per,
        floor=float(curve["floor"]) * per,
        threshold=plan.settings.sig_threshold,
        scale=scale,
        moving=bool(curve["moving"]),
        pace=float(state["window"]["pace"]),
        own_time=float(state["scales"]["own_time"]) if plan.traits.has_features else None,
        pose=np.ascontiguousarray(pose, np.float32),
    )


def _reported_time(row: NDArray[np.uint8]) -> float:
    """Return the reported time of a key frame at the last processed frame, s: that of a kept pose; see `note_place`."""
    state = records(row)
    taken = float(state["clock"]["taken_time"])
    wanted = taken - (EARLIER_IN_NOISE if state["noise"]["loud"] else EARLIER)
    history = state["history"]
    newest = (int(history["head"]) - 1 - np.arange(int(history["filled"]))) % int(
        state["plan"]["history_size"]
    )
    kept = region(row, "marks")["time"][newest]
    distance = np.abs(kept - wanted)
    return float(kept[np.argmax(distance < distance.min() + MARGIN)])
