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

from mossar_stream.core.kernels import CACHE_LINE, PAGE, PAGE_SIZE, RECORDS, pad, samples_bytes

PLAN, ROW = RECORDS["Plan"], RECORDS["Row"]
# A row's arrays: (name, dtype). Sizes are given by `region_sizes`.
REGIONS: tuple[tuple[str, str], ...] = (
    ("body", "f4"),  # positions and displacements of the joints, see joint_pages.pxi
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
    ("keys", "Key"),  # (W + 2,) undecided key frames, from left to right
    ("counts", "i4"),  # (W + 3, W + 2) messages sent about each segment of the window
    ("memo", "Memo"),  # (memo,) merge costs computed before
    ("marks", "Mark"),  # (history_size,) of the poses kept to take speeds from and to move key frames
    ("poses", "i2"),  # (history_size, 3, padded_joints) 1/8192 m, those poses
    ("bouts", "Bout"),  # (bouts,) of movement, the latest that have ended
    ("notes", "Note"),  # (notes,) of the last candidates
    ("counted", "Counting"),  # (1,) of repetitions, if they are counted here
    ("periods", "Periods"),  # (1,) of it, by which candidates are judged
    ("samples", "u1"),  # of them, see repetitions/state.pxi
    ("adopted", "Periods"),  # (1,) of a limb: what is counted of its body, by which its candidates are judged
)

ROW_BYTES = ROW.itemsize


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
    return RECORDS[kind] if kind in RECORDS else np.dtype(kind)


def body_size(joints: int) -> int:
    """Return the length of the body of so many joints, float32 numbers."""
    return -(-joints // PAGE) * PAGE_SIZE


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
