"""Where one performer's state lives: a single row of bytes.

Everything a segmenter remembers of one performer is one row: a `HEADER` record, then arrays whose sizes follow
from the joints and the settings. A snapshot is a copy of the row, a pool of performers is a matrix of rows, and
nothing is allocated while frames come in. Compiled code looks at a row through views; the offsets of the arrays
stand in the header, in bytes from the row's start.
"""

import math
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream.memory.joint_pages import body_size

PATH_JOINTS = 5  # joints named as active in a segment
CACHE_LINE = 64  # bytes
LANES = 8  # joints are padded to a multiple of this, so that loops over joints vectorise

# What a frame's arrays hold, by region: (name, dtype). Sizes are given by `region_sizes`.
REGIONS: tuple[tuple[str, str], ...] = (
    ("body", "f4"),  # positions and displacements of the joints, see joint_pages.py
    ("seen", "f8"),  # (lanes,) s, when each joint was last there; -inf if never
    ("filtered", "f8"),  # (6, lanes) m and m/s, One-Euro filter
    ("pose", "f4"),  # (4, lanes) last frame's features as one array, see body.flatten
    ("ring_time", "f8"),  # (ring,) s, ends of the displacements in the velocity window
    ("ring_step", "i8"),  # (ring,) 2^-40 m, those displacements summed over the joints
    ("average", "i8"),  # (smoothing_window,) 2^-40 m, velocities under the moving average
    ("slots", "f8"),  # (slots, slot) summaries of segments, see summary.py
    ("free", "i8"),  # (slots,) stack of unused slots
    ("order", "i8"),  # (W + 2,) slots of the window's segments, from left to right
    ("keys", "KEY"),  # (W + 2,) undecided key frames, from left to right
    ("counts", "i8"),  # (W + 3, W + 2) messages sent about each segment of the window
    ("memo", "MEMO"),  # (memo,) strengths computed before
    ("marks", "MARK"),  # (trail,) of the poses kept to take speeds from and to move key frames
    ("trail", "i2"),  # (trail, 3, lanes) 1/8192 m, those poses
)

KEY = np.dtype(
    [
        ("ordinal", "i8"),  # counts the key frames of the take
        ("frame", "i8"),  # Algorithm 2's frame
        ("time", "f8"),  # s
        ("velocity", "f8"),  # share of the range
        ("strength", "f8"),  # NaN until first computed
        ("kind", "i8"),  # index into events.KEY_FRAME_KINDS
        ("standing", "i8"),  # whether it stands at the current level
        ("before", "i8"),  # ordinal of the standing key frame before; LEFT for the window's left end
        ("place", "i8"),  # in the order in which key frames fall
        ("rev", "i8"),  # messages sent
    ],
)
MARK = np.dtype([("time", "f8"), ("frame", "i8"), ("weight", "f8")])  # s, number, s that the pose stands for
MEMO = np.dtype([("left", "i8"), ("middle", "i8"), ("right", "i8"), ("strength", "f8")])

_HEADER_FIELDS: list[tuple[str, str]] = [
    # Fixed while the row lives.
    ("row", "i8"),  # its place in the pool
    ("joints", "i8"),
    ("lanes", "i8"),
    ("center", "i8"),  # index of the root, -1 for the centroid
    ("flat", "i8"),  # whether the similarity takes the pose as one array
    ("moving_joints", "i8"),  # joints that can move relative to the centre
    ("filter_lanes", "i8"),  # lanes, or 0 without a One-Euro filter
    ("average_size", "i8"),
    ("ring", "i8"),
    ("slot", "i8"),
    ("slot_count", "i8"),
    ("memo_size", "i8"),
    ("trail_size", "i8"),
    ("capacity", "i8"),  # W
    ("most_events", "i8"),  # that one frame, or the end of a take, can cause
    # Settings; the row's own, so that a level can move while others stay.
    ("window", "f8"),
    ("smoothing", "i8"),
    ("smoothing_window", "i8"),
    ("one_euro_cutoff", "f8"),
    ("one_euro_beta", "f8"),
    ("theta", "f8"),
    ("range_policy", "i8"),
    ("range_min", "f8"),
    ("range_max", "f8"),
    ("range_half_life", "f8"),
    ("range_floor", "f8"),  # m, for all joints together
    ("noise_margin", "f8"),  # 0 if it is off
    ("max_gap", "f8"),
    ("max_speed", "f8"),
    ("max_pause", "f8"),
    ("hold", "f8"),
    ("level", "f8"),
    ("pace", "f8"),  # tempo factor of the last ranking: costs are divided by it
    ("location", "i8"),
    ("refine", "f8"),
    ("pre_roll", "f8"),
    ("post_roll", "f8"),
    ("tempo", "i8"),
    ("offline", "i8"),  # keep every key frame until the take ends, and decide then
    ("keep", "i8"),  # alpha of Algorithm 3: this many key frames stand whatever their strength
    # Stream.
    ("take", "i8"),
    ("open", "i8"),  # whether a take is open
    ("next_frame", "i8"),  # number of the next one
    ("time", "f8"),  # s, of the last used frame
    ("used_frame", "i8"),  # number of the last used frame
    ("start_time", "f8"),
    ("complete", "i8"),  # whether all joints were there in the last frame
    # Counters since the row was made.
    ("frames", "i8"),
    ("out_of_order", "i8"),
    ("outliers", "i8"),
    ("held", "i8"),
    ("gaps", "i8"),
    # Velocity.
    ("head", "i8"),  # next place in the ring
    ("filled", "i8"),  # entries in the ring
    ("travelled", "i8"),  # 2^-40 m, sum of the ring
    ("average_head", "i8"),
    ("average_filled", "i8"),
    ("average_sum", "i8"),
    # Range.
    ("largest", "f8"),
    # Noise.
    ("noise_known", "i8"),  # whether it was ever calm
    ("noise_smooth", "i8"),  # whether the last displacement was smoothed
    ("noise_heard", "f8"),  # s, of movement
    ("noise_time", "f8"),  # s, since the last frame that was not a repetition
    ("noise_step", "f8"),  # s, usual time between frames
    ("noise_span", "f8"),  # s, that the following leaky sums stand for
    ("noise_path", "f8"),  # m
    ("noise_squares", "f8"),  # m², of the last displacements
    ("noise_turn", "f8"),  # s, correlation of successive displacements
    ("noise", "f8"),  # m/s, path of the noise of all joints
    ("noise_floor", "f8"),  # m, the range does not fall below it
    # Envelope and splitter.
    ("ceiling", "f8"),
    ("floor", "f8"),
    ("moving", "i8"),
    ("value", "f8"),  # last velocity
    ("run_frame", "i8"),  # first frame of the run of equal values that ends now
    ("run_time", "f8"),
    ("run_length", "i8"),
    ("falling", "i8"),  # the run was entered from above
    ("testable", "i8"),  # the run's first frame is at Floor, moving, and no crossing
    ("share", "f8"),  # the run's value as a share of the range
    ("awaiting", "i8"),  # whether the maximum that accepts the newest minimum is still to come
    ("candidate", "i8"),  # frame of the candidate, -1 if none
    ("candidate_time", "f8"),
    ("candidate_value", "f8"),
    ("candidate_share", "f8"),
    # Open segment: up to the candidate, since the candidate, since the current run began.
    ("slot_settled", "i8"),
    ("slot_since", "i8"),
    ("slot_run", "i8"),
    ("fed", "i8"),  # slot that the sums in the body belong to
    ("waiting", "i8"),  # frames in them
    ("pending_time", "f8"),  # s, of the last frame, which is in no summary yet
    ("pending_weight", "f8"),  # s
    ("pending_moving", "i8"),
    # What the splitter found in the last frame.
    ("happened", "i8"),  # flags of splitter.py; 0 when dealt with
    ("former_frame", "i8"),  # the candidate that was replaced
    ("former_time", "f8"),
    ("former_share", "f8"),
    ("found_frame", "i8"),  # the candidate that was promoted, forgotten or confirmed
    ("found_time", "f8"),
    ("found_share", "f8"),
    ("closed", "i8"),  # slot of the segment that a key frame ended, -1 if none
    # Window.
    ("free_count", "i8"),
    ("undecided", "i8"),
    ("ordinal", "i8"),  # of the next key frame
    ("ranked", "i8"),  # whether the strengths are those of the window as it is
    ("left_frame", "i8"),  # where the window's first segment starts: the last final key frame
    ("left_id", "i8"),  # Algorithm 2's frame of it
    ("left_time", "f8"),
    ("left_ordinal", "i8"),
    ("has_before", "i8"),  # whether slot_before holds the segment before the window
    ("slot_before", "i8"),
    ("due_time", "f8"),  # s, when the oldest undecided key frame must be decided; inf if there is none
    # Tempo.
    ("spread", "f8"),  # m² s, leaky sum of the joints' squared distances from the mean pose
    ("squared_speed", "f8"),  # m²/s, leaky sum of their squared speeds
    # Trail of poses for the location step.
    ("trail_head", "i8"),
    ("trail_filled", "i8"),
    ("trail_debt", "f8"),  # s, since the last pose that was kept
]
HEADER = np.dtype(_HEADER_FIELDS + [(f"at_{name}", "i8") for name, _ in REGIONS])
HEADER_BYTES = HEADER.itemsize
_DTYPES = {"KEY": KEY, "MARK": MARK, "MEMO": MEMO}


class Shape(msgspec.Struct, frozen=True):
    """Sizes from which a row's layout follows.

    Args:
        joints: J.
        ring: Displacements that the velocity window can hold.
        slot: Length of one segment summary, float64 numbers.
        window: W.
        smoothing_window: Frames under the moving average; 0 if off.
        one_euro: Whether the joints are filtered.
        trail: Poses kept.
        counted: Whether messages about segments are counted; not offline, where each has one.
    """

    joints: int
    ring: int
    slot: int
    window: int
    smoothing_window: int
    one_euro: bool
    trail: int
    counted: bool

    @staticmethod
    def pad(joints: int) -> int:
        """Return the number of lanes for a number of joints."""
        return -(-joints // LANES) * LANES

    @property
    def lanes(self) -> int:
        """Joints, padded."""
        return self.pad(self.joints)

    @property
    def slots(self) -> int:
        """W + 1 segments of the window, the one before it, three of the open segment, one to spare."""
        return self.window + 6

    @property
    def memo(self) -> int:
        """Places for remembered costs, a power of two."""
        return int(2 ** math.ceil(math.log2(4 * self.window + 4)))

    def region_sizes(self) -> dict[str, int]:
        """Return the number of items of each region."""
        lanes, window = self.lanes, self.window
        return {
            "body": body_size(self.joints),
            "seen": lanes,
            "filtered": 6 * lanes * self.one_euro,
            "pose": 4 * lanes,
            "ring_time": self.ring,
            "ring_step": self.ring,
            "average": self.smoothing_window,
            "slots": self.slots * self.slot,
            "free": self.slots,
            "order": window + 2,
            "keys": window + 2,
            "counts": (window + 3) * (window + 2) * self.counted,
            "memo": self.memo,
            "marks": self.trail,
            "trail": self.trail * 3 * lanes,
        }

    def offsets(self) -> tuple[dict[str, int], int]:
        """Return the offset of each region and the length of the row, bytes."""
        place, at = {}, -(-HEADER_BYTES // 64) * 64
        sizes = self.region_sizes()
        for name, kind in REGIONS:
            place[name] = at
            at += -(-sizes[name] * _item(kind).itemsize // 64) * 64
        return place, at


def _item(kind: str) -> np.dtype[np.generic]:
    return _DTYPES[kind] if kind in _DTYPES else np.dtype(kind)


def new_memory(count: int, size: int) -> NDArray[np.uint8]:
    """Return (count, size) bytes, zero, that begin with a line of the cache.

    The compiled loops work on 64 bytes at a time; where these lie in two lines each, they take half as long again.
    """
    spare = np.zeros(count * size + CACHE_LINE, np.uint8)
    begin = -spare.ctypes.data % CACHE_LINE
    return spare[begin : begin + count * size].reshape(count, size)


def header(row: NDArray[np.uint8]) -> Any:
    """Return a row's header as a numpy record that writes through to the row."""
    return row[:HEADER_BYTES].view(HEADER)[0]


def region(row: NDArray[np.uint8], shape: Shape, name: str) -> NDArray[Any]:
    """Return one of a row's arrays, flat, as a view."""
    kind = _item(dict(REGIONS)[name])
    start = shape.offsets()[0][name]
    return row[start : start + shape.region_sizes()[name] * kind.itemsize].view(kind)
