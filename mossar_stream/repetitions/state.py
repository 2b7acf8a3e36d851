"""State of one performer's repetitions: a record of fixed size, and samples.

A sample is a pose that has moved far enough from the sample before (sampling.py). Samples lie coordinate by coordinate, as
16-bit multiples of a quantum, so that both products of a power iteration run along contiguous memory; only the root, which
may go far, has its own path in full.
"""

from typing import NamedTuple

import numpy as np

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.jit.views import part

RATE = 30.0  # Hz, of the frames that are looked at, at most
SAMPLES = 120  # kept
LEAST_SAMPLES = 8  # in a window that is analysed
RECENT = 40  # samples: what swings much less there than in the window followed another posture
STRIDE = 10  # samples after which the window is analysed,
ANALYSIS_INTERVAL = 1.0  # s, at the latest, if there is a new one
COMPONENTS = 4  # leading ones of the posture; cycles are compared in them
REST_POSE_FRAMES = 15  # frames of a take of which the rest pose is the mean
CYCLES = 32  # remembered; more than fit into the window
CHAINS = 24  # at most: bones in pairs, such as upper arm and forearm, by which it is known how limbs are held

MOST_QUANTA = np.float32(32767.0)  # largest multiple of the quantum
SMALLEST_QUANTUM = 1.0 / 8192.0  # m: reaches 4 m from the root
LEAST_REACH = 8.0  # times the rms distance of joints from their centre, which the quantum reaches at least

POSTURES = 9  # that describe a cycle
BINS = 64  # of histograms

CYCLE = np.dtype(
    [
        ("start", "i8"),  # sample at which the cycle begins, counted from the start of the take
        ("far", "i8"),  # sample of the other extreme
        ("end", "i8"),
        (
            "leaves",
            "f8",
        ),  # s since the take began, like all times: when it leaves the pose in which it begins,
        ("out", "f8"),  # passes half way to the other extreme,
        ("turns", "f8"),  # is there, in the middle of its stay,
        ("back", "f8"),  # passes half way back,
        ("arrives", "f8"),  # and arrives
        ("returning", "i8"),  # 1 if it may be on its way back yet
        ("amplitude", "f8"),  # m, rms over joints, from one extreme to the other
        ("count", "i8"),  # in its bout, from 1
        ("joint", "i8"),  # that moves most
        (
            "straighter",
            "f8",
        ),  # how much straighter and more upright limbs are where the cycle begins than at the other extreme
        ("resting", "f8"),  # how much more the movement dwells there and is near the rest pose, from -1 to 1
        ("lead", "f8"),  # share of a cycle that was shown before the first one of its bout
        ("turned", "i8"),  # 1 if repetitions begin at the other extreme
        ("begins", "f8"),  # s, where the repetition begins, and
        ("ends", "f8"),  # where it ends, see timing.py
        ("period", "f8"),  # s, NaN of the first in a bout
    ]
)

HEADER = np.dtype(
    [
        ("joints", "i8"),
        ("root", "i8"),
        ("travels", "i8"),  # 1 if the root's own path is part of the posture
        ("least", "f8"),  # m, rms over joints: what swings by less is not counted
        ("chains", "i8"),  # how many there are
        ("chain", "i8", (CHAINS, 3)),  # joints: the end of one bone, what both share, the end of the other
        ("begun", "i8"),  # 1 after the first frame of a take
        ("origin", "f8"),  # s, time of that frame
        ("latest", "f8"),  # s, time of the latest frame
        ("wanted", "f8"),  # s, from when on a frame is looked at
        ("unseen", "i8"),  # coordinates that no frame of the take had
        ("frames", "i8"),  # looked at
        ("middle", "f8"),  # s, time of the frame before, which is the middle one of three
        ("noise", "f8"),  # m², of the sensor: variance of a pose, added up over all coordinates
        ("size", "f8"),  # m², square of how far joints are from their centre, added up, as the take began
        ("quantum", "f4"),  # m, of which samples are multiples
        ("per_quantum", "f4"),  # 1/m
        ("step", "f8"),  # m², by which a pose must differ from the last sample, added up likewise
        ("wander", "f8"),  # m², how far the pose went from the last sample, and
        ("returns", "i8"),  # how often it came back: small movements, of which a large step shows nothing
        ("fine", "i8"),  # first sample since the step was last made smaller
        ("open", "i8"),  # samples of the take
        ("first", "i8"),  # that belongs to the window: before it there was a long rest
        ("analysed", "i8"),  # samples at the last analysis
        ("due", "f8"),  # s, when the next analysis is due
        ("at", "f8", (SAMPLES,)),  # s since the take began, times of the samples, ring buffer
        ("left", "f8", (SAMPLES,)),  # s, until when the pose stayed there
        ("clear", "i8"),  # 1 once some cycles agreed beyond doubt; nothing is reported before
        ("dropped", "i8"),  # cycles that are no longer remembered
        ("cycles", "i8"),  # remembered ones
        ("changed", "i8"),  # the first remembered cycle that the last analysis changed
        ("cycle", CYCLE, (CYCLES,)),
    ]
)

PERIODS = (
    np.dtype(  # what evidence reads of it: of the body's repetitions, in its row and in those of its limbs
        [
            ("origin", "f8"),  # as in `HEADER`, and so are the others
            ("analysed", "i8"),
            ("clear", "i8"),
            ("cycles", "i8"),
            ("cycle", [("begins", "f8"), ("ends", "f8"), ("period", "f8"), ("count", "i8")], (CYCLES,)),
        ]
    )
)

WINNER = np.dtype(
    [("covered", "f8"), ("count", "i8"), ("component", "i8"), ("width", "i8"), ("clear", "i8")],
)

# Arrays that an analysis works in; passed to kernels, since kernels that make none are quicker.
SCRATCH = np.dtype(
    [
        ("turns", "i4", (2, SAMPLES)),  # see `turning_points`
        ("cycles", "i4", (3, SAMPLES)),  # start, far extreme, end
        ("kept", "i4", (3, SAMPLES)),  # those that are alike
        ("best", "i4", (3, SAMPLES)),  # those of the proposal that wins so far
        ("missed", "i4", (3,)),  # one
        ("shapes", "f4", (SAMPLES // 2, POSTURES, COMPONENTS)),  # descriptions of cycles
        (
            "totals",
            "f4",
            (SAMPLES // 2, COMPONENTS + 1),
        ),  # sums of each component of them, and of all squares
        ("alike", "f8", (SAMPLES // 2,)),  # agreement of each cycle with the next
        ("counts", "i4", (BINS,)),  # of a histogram
        ("least", "f8"),  # swing of scores; what swings by less is not counted
        ("winner", WINNER),
    ]
)

LINE = 64  # bytes; what is analysed begins with one
PERIODS_AT = -(-HEADER.itemsize // LINE) * LINE  # where the periods begin, after the header,
SAMPLES_AT = PERIODS_AT + -(-PERIODS.itemsize // LINE) * LINE  # and the samples
ROOM_AT = -(-SCRATCH.itemsize // LINE) * LINE

GIVEN = (
    "joints",
    "root",
    "travels",
    "least",
    "chains",
    "chain",
)  # with the skeleton, for all takes


class StoredSamples(NamedTuple):
    """Views of what is kept of one performer; D = 3 · joints, float32 but for the samples."""

    ring: (
        np.ndarray
    )  # (D, SAMPLES) int16, samples in quanta, joints relative to the root; each line a ring buffer
    root: np.ndarray  # (3, SAMPLES) m, the root of each sample: its own path, or 0; ring buffers as `ring`
    axes: np.ndarray  # (COMPONENTS, D), unit vectors
    straight: np.ndarray  # (SAMPLES,) how straight and upright limbs are, 0 to 2, ring buffer as `ring`
    last: np.ndarray  # (D,) m, pose of the last sample
    older: np.ndarray  # (D,) m, pose of the frame before `before`
    before: np.ndarray  # (D,) m, pose of the frame before
    rest_pose: np.ndarray  # (D,) m, mean pose of the take's first `REST_POSE_FRAMES` frames
    pose: np.ndarray  # (D,) latest known, NaN before a joint was seen


class Samples(NamedTuple):
    """What an analysis works with: what is stored, and arrays that performers share, because they are analysed one after the other."""

    ring: np.ndarray  # as in `StoredSamples`
    root: np.ndarray
    axes: np.ndarray
    straight: np.ndarray
    last: np.ndarray
    older: np.ndarray
    before: np.ndarray
    rest_pose: np.ndarray
    pose: np.ndarray
    by_coordinate: np.ndarray  # (D, SAMPLES), m, in the order of time
    scores: np.ndarray  # (COMPONENTS, SAMPLES), in the order of time
    smooth: np.ndarray  # (COMPONENTS, SAMPLES), means of neighbours of them
    rest_pose_scores: np.ndarray  # (COMPONENTS,) of the pose `rest_pose`, as `scores`


def samples_bytes(joints: int) -> int:
    """Return the bytes of a performer's samples, with what is kept beside them."""
    return 3 * joints * (2 * SAMPLES + 4 * (COMPONENTS + 5)) + 4 * 4 * SAMPLES


def store_size(joints: int) -> int:
    """Return the bytes in which an analysis works, for any performer of so many joints: `SCRATCH`, then numbers."""
    return ROOM_AT + 4 * (3 * joints * SAMPLES + COMPONENTS * (2 * SAMPLES + 1))


@inline_kernel(returns_views=True)
def stored_views(memory, joints):
    """Return the parts of a performer's array as `StoredSamples`; of no joints there are none."""
    d = 3 * joints
    n = SAMPLES if joints > 0 else 0
    at_root = 2 * d * SAMPLES
    at_axes = at_root + 4 * 3 * n
    at_straight = at_axes + 4 * COMPONENTS * d
    at_poses = at_straight + 4 * n
    return StoredSamples(
        part(memory, 0, np.int16, (d, SAMPLES)),
        part(memory, at_root, np.float32, (3, n)),
        part(memory, at_axes, np.float32, (COMPONENTS, d)),
        part(memory, at_straight, np.float32, (n,)),
        part(memory, at_poses, np.float32, (d,)),
        part(memory, at_poses + 4 * d, np.float32, (d,)),
        part(memory, at_poses + 8 * d, np.float32, (d,)),
        part(memory, at_poses + 12 * d, np.float32, (d,)),
        part(memory, at_poses + 16 * d, np.float32, (d,)),
    )


@inline_kernel(returns_views=True)
def views(memory, room, joints):
    """Return the parts of a performer's array and of the numbers of a store as `Samples`."""
    d = 3 * joints
    a = d * SAMPLES
    b = a + COMPONENTS * SAMPLES
    c = b + COMPONENTS * SAMPLES
    stored = stored_views(memory, joints)
    return Samples(
        stored.ring,
        stored.root,
        stored.axes,
        stored.straight,
        stored.last,
        stored.older,
        stored.before,
        stored.rest_pose,
        stored.pose,
        part(room, 0, np.float32, (d, SAMPLES)),
        part(room, 4 * a, np.float32, (COMPONENTS, SAMPLES)),
        part(room, 4 * b, np.float32, (COMPONENTS, SAMPLES)),
        part(room, 4 * c, np.float32, (COMPONENTS,)),
    )


@kernel
def begin(header, samples, time):
    """Begin a take: forget everything but the skeleton.

    Args:
        header: `HEADER` record.
        samples: `StoredSamples`.
        time: s, of the first frame.
    """
    header.begun = 1
    header.origin = header.latest = header.wanted = time
    header.unseen = 3 * header.joints
    header.frames = header.open = header.clear = header.dropped = header.cycles = header.changed = 0
    header.first = header.fine = header.returns = 0
    header.noise = header.size = header.step = header.wander = header.middle = 0.0
    note_analysis(header)
    header.quantum, header.per_quantum = SMALLEST_QUANTUM, 1.0 / SMALLEST_QUANTUM
    samples.axes[:] = 0.0
    samples.rest_pose[:] = 0.0
    samples.pose[:] = np.nan


@kernel
def forget_periods(periods):
    """Forget what is counted, as a take begins."""
    periods.clear = periods.cycles = periods.analysed = 0


@kernel
def copy_periods(periods, counted):
    """Set `PERIODS` to what is counted.

    Args:
        periods: `PERIODS` record.
        counted: `HEADER` or `PERIODS` record.
    """
    periods.origin, periods.analysed = counted.origin, counted.analysed
    periods.clear, periods.cycles = counted.clear, counted.cycles
    for q in range(counted.cycles):
        to, cycle = periods.cycle[q], counted.cycle[q]
        to.begins, to.ends, to.period, to.count = cycle.begins, cycle.ends, cycle.period, cycle.count


@kernel
def note_analysis(header):
    """Note that all samples were analysed; the next one says when an analysis is due again."""
    header.analysed = header.open
    header.due = np.inf


@inline_kernel
def window_size(header):
    """Return how many samples there are in the window."""
    return min(header.open - header.first, SAMPLES)


@inline_kernel
def ring_place(header, n, i):
    """Return where in the ring the i-th of the n samples in the window is."""
    return (header.open - n + i) % SAMPLES
