"""Row: where one performer's state lives.

Everything that is remembered of one performer is one row of bytes: the records of all concepts (each declared beside
the functions that write it), then arrays whose sizes follow from the joints and the settings. A snapshot is a copy of
the row, a pool of performers is a matrix of rows, and nothing is allocated while frames come in. Compiled code looks
at a row through views; where the arrays begin stands in the record `at`, in bytes from the row's start.
"""

import math
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream.algorithm.activity import ACTIVITY_STATE, BOUT
from mossar_stream.algorithm.candidate_features import CANDIDATE
from mossar_stream.algorithm.clock import CLOCK, COUNTERS
from mossar_stream.algorithm.joints import JOINTS
from mossar_stream.algorithm.noise import NOISE
from mossar_stream.algorithm.normalisation import RANGE
from mossar_stream.algorithm.open_segment import OPEN_SEGMENT
from mossar_stream.algorithm.pose_history import HISTORY, MARK
from mossar_stream.algorithm.remerging import MEMO
from mossar_stream.algorithm.repetition_labels import LABELS, NOTE
from mossar_stream.algorithm.scales import SCALES
from mossar_stream.algorithm.splitter import CURVE
from mossar_stream.algorithm.tempo import TEMPO
from mossar_stream.algorithm.velocity import AVERAGE, VELOCITY
from mossar_stream.algorithm.window import KEY, WINDOW
from mossar_stream.memory.joint_pages import body_size, pad
from mossar_stream.memory.slots import SLOTS
from mossar_stream.repetitions.state import HEADER, PERIODS, samples_bytes

CACHE_LINE = 64  # bytes

# A row's arrays: (name, dtype). Sizes are given by `region_sizes`.
REGIONS: tuple[tuple[str, str], ...] = (
    ("body", "f4"),  # positions and displacements of the joints, see joint_pages.py
    ("seen", "f8"),  # (padded_joints,) s, when each joint was last there; -inf if never
    ("tracked", "i4"),  # (padded_joints,) frames that bear out where each joint is, see joints.py
    ("filtered", "f8"),  # (6, padded_joints) m and m/s, One-Euro filter
    ("pose", "f4"),  # (4, padded_joints) last frame's features as one array, see joint_pages.flatten
    ("ring_time", "f8"),  # (ring,) s, ends of the displacements in the velocity window
    ("ring_step", "i8"),  # (ring,) 2^-40 m, those displacements summed over the joints
    ("average", "i8"),  # (smoothing_window,) 2^-40 m, velocities under the moving average
    ("summaries", "f8"),  # (slots, slot) summaries of segments, see summary.py
    ("unused", "i8"),  # (slots,) stack of unused slots
    ("order", "i8"),  # (W + 2,) slots of the window's segments, from left to right
    ("keys", "KEY"),  # (W + 2,) undecided key frames, from left to right
    ("counts", "i4"),  # (W + 3, W + 2) messages sent about each segment of the window
    ("memo", "MEMO"),  # (memo,) merge costs computed before
    ("marks", "MARK"),  # (history_size,) of the poses kept to take speeds from and to move key frames
    ("poses", "i2"),  # (history_size, 3, padded_joints) 1/8192 m, those poses
    ("bouts", "BOUT"),  # (bouts,) of movement, the latest that have ended
    ("notes", "NOTE"),  # (notes,) of the last candidates
    ("counted", "HEADER"),  # (1,) of repetitions, if they are counted here
    ("periods", "PERIODS"),  # (1,) of it, by which candidates are judged
    ("samples", "u1"),  # of them, see repetitions/state.py
    ("adopted", "PERIODS"),  # (1,) of a limb: what is counted of its body, by which its candidates are judged
)

PLAN = np.dtype(  # what does not change while frames come in; `Plan.prepare` sets it
    [
        # Sizes.
        ("joints", "i8"),
        ("padded_joints", "i8"),
        ("center", "i8"),  # index of the root, -1 for the centroid
        ("flat", "i8"),  # whether the similarity takes the pose as one array
        ("moving_joints", "i8"),  # joints that can move relative to the centre
        ("filtered_joints", "i8"),  # padded joints, or 0 without a One-Euro filter
        ("average_size", "i8"),
        ("ring", "i8"),
        ("slot", "i8"),
        ("slot_count", "i8"),
        ("memo_size", "i8"),
        ("history_size", "i8"),
        ("bouts", "i8"),
        ("notes", "i8"),
        ("samples", "i8"),  # bytes of the repetitions' samples
        ("capacity", "i8"),  # W
        ("room", "i8"),  # with more undecided key frames than this the row must grow before the next frame
        ("most_events", "i8"),  # that one frame, or the end of a take, can cause
        # Settings; the row's own, so that a level can move while others stay.
        ("window", "f8"),  # s
        ("smoothing", "i8"),
        ("one_euro_cutoff", "f8"),
        ("one_euro_beta", "f8"),
        ("theta", "f8"),  # sigThre, share of the range
        ("rest_seconds", "f8"),  # s
        ("rests", "i8"),  # whether they are segments of their own
        ("range_policy", "i8"),
        ("range_min", "f8"),
        ("range_max", "f8"),
        ("range_half_life", "f8"),
        ("range_floor", "f8"),  # m, for all joints together
        ("noise_margin", "f8"),  # 0 if it is off
        ("spacing", "f8"),  # s, minimum interval of processed frames
        ("max_gap", "f8"),  # s
        ("max_speed", "f8"),  # m/s
        ("max_pause", "f8"),  # s
        ("hold", "f8"),  # s, after which a key frame is decided
        (
            "alpha",
            "i8",
        ),  # α of Algorithm 3: this many key frames are kept whatever their strength; 0 for none
        ("beta", "f8"),  # β of Algorithm 3, the level, as a strength
        ("location", "i8"),
        ("refine", "f8"),  # s
        ("pre_roll", "f8"),  # s
        ("post_roll", "f8"),  # s
        ("tempo", "i8"),
        ("is_filtered", "i8"),  # see `Traits` in similarity/summary.py
        ("is_rms", "i8"),
        ("has_features", "i8"),
        ("is_mean", "i8"),
        ("repetitions", "i8"),  # whether they are counted here
        ("ends_alone", "i8"),  # whether its takes end where nobody is seen; a limb's end with the body's
        ("details", "u8"),  # a bit for each of the first 64 joints that is not reported as active
        ("adopts", "i8"),  # whether what is counted of the body is copied here
        ("labels_late", "i8"),  # whether labels wait for what is counted
        ("offline", "i8"),  # keep every key frame until the take ends, and decide then
    ],
)
ROW = np.dtype(
    [
        ("plan", PLAN),
        ("clock", CLOCK),
        ("counters", COUNTERS),
        ("joints", JOINTS),
        ("noise", NOISE),
        ("velocity", VELOCITY),
        ("average", AVERAGE),
        ("range", RANGE),
        ("curve", CURVE),
        ("open_segment", OPEN_SEGMENT),
        ("slots", SLOTS),
        ("history", HISTORY),
        ("tempo", TEMPO),
        ("scales", SCALES),
        ("labels", LABELS),
        ("candidate", CANDIDATE),
        ("activity", ACTIVITY_STATE),
        ("window", WINDOW),
        ("at", [(name, "i8") for name, _ in REGIONS]),
    ],
)
ROW_BYTES = ROW.itemsize
_DTYPES = {
    "KEY": KEY,
    "NOTE": NOTE,
    "HEADER": HEADER,
    "PERIODS": PERIODS,
    "MARK": MARK,
    "MEMO": MEMO,
    "BOUT": BOUT,
}


class Shape(msgspec.Struct, frozen=True):
    """Sizes from which a row's layout follows.

    Args:
        joints: J.
        ring: Displacements that the velocity window can hold.
        slot: Length of one segment summary, float64 numbers.
        window: W.
        room: Undecided key frames whose segments there are slots for, at most W; a row grows when it needs more.
        smoothing_window: Frames under the moving average; 0 if off.
        one_euro: Whether the joints are filtered.
        history: Poses kept.
        bouts: Bouts of movement kept.
        counted: Whether messages about segments are counted; not offline, where each has one.
        features: Whether key frames come with features.
        notes: Candidates that are remembered to be labelled.
        repetitions: Whether they are counted here.
        adopts: Whether what is counted of the body is copied here.
    """

    joints: int
    ring: int
    slot: int
    window: int
    room: int
    smoothing_window: int
    one_euro: bool
    history: int
    bouts: int
    counted: bool
    features: bool
    notes: int
    repetitions: bool
    adopts: bool

    @property
    def padded_joints(self) -> int:
        """Joints, padded."""
        return pad(self.joints)

    @property
    def slots(self) -> int:
        """One more segment than there is room for, the one before them, three of the open segment, one to spare."""
        return self.room + 6

    @property
    def memo(self) -> int:
        """Places for remembered costs, a power of two."""
        places = (8 if self.features else 4) * (self.window + 1)  # with features costs change more often
        return int(2 ** math.ceil(math.log2(places)))

    def region_sizes(self) -> dict[str, int]:
        """Return the number of items of each region."""
        joints, window = self.padded_joints, self.window
        return {
            "body": body_size(self.joints),
            "seen": joints,
            "tracked": joints,
            "filtered": 6 * joints * self.one_euro,
            "pose": 4 * joints,
            "ring_time": self.ring,
            "ring_step": self.ring,
            "average": self.smoothing_window,
            "summaries": self.slots * self.slot,
            "unused": self.slots,
            "order": window + 2,
            "keys": window + 2,
            "counts": (window + 3) * (window + 2) * self.counted,
            "memo": self.memo,
            "marks": self.history,
            "poses": self.history * 3 * joints,
            "bouts": self.bouts,
            "notes": self.notes,
            "counted": int(self.repetitions),
            "periods": int(self.repetitions),
            "samples": samples_bytes(self.joints) * self.repetitions,
            "adopted": int(self.adopts),
        }

    def offsets(self) -> tuple[dict[str, int], int]:
        """Return the offset of each region and the length of the row, bytes."""
        place, at = {}, -(-ROW_BYTES // CACHE_LINE) * CACHE_LINE
        sizes = self.region_sizes()
        for name, kind in REGIONS:
            place[name] = at
            at += -(-sizes[name] * _item(kind).itemsize // CACHE_LINE) * CACHE_LINE
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


def records(row: NDArray[np.uint8]) -> Any:
    """Return a row's records as one numpy record that writes through to the row."""
    return row[:ROW_BYTES].view(ROW)[0]


def region(row: NDArray[np.uint8], shape: Shape, name: str) -> NDArray[Any]:
    """Return one of a row's arrays, flat, as a view."""
    kind = _item(dict(REGIONS)[name])
    start = shape.offsets()[0][name]
    return row[start : start + shape.region_sizes()[name] * kind.itemsize].view(kind)
