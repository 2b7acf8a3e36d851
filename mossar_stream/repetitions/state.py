"""State of one performer's repetitions: a record of fixed size and one array of samples.

Poses are kept at `RATE` over the last `WINDOW` seconds, twice: by sample and by coordinate, so that both products of a
power iteration run along contiguous memory.
"""

from typing import NamedTuple

import numpy as np

from mossar_stream.jit.decorators import inline_kernel

RATE = 10.0  # Hz, of the samples
FRAMES = 3  # that make a sample, if there are as many, evenly spread: the others are passed over
SAMPLES = 120  # kept, which is 12 s
STRIDE = 10  # samples between two looks at the window
COMPONENTS = 4  # leading ones of the posture; cycles are compared in them
HOME = 5  # samples from which on it is known where movements begin
CYCLES = 64  # remembered; more than fit into the window
CHAINS = 24  # at most: bones in pairs, such as upper arm and forearm, by which it is known how limbs are held

POSTURES = 9  # that describe a cycle
BINS = 64  # of histograms

CYCLE = np.dtype(
    [
        ("start", "i8"),  # sample at which the cycle begins, counted from the start of the take
        ("far", "i8"),  # sample of the other extreme
        ("end", "i8"),
        ("out", "f8"),  # samples, where it passes half way to the other extreme, and
        ("back", "f8"),  # half way back: better timed than the extremes
        ("amplitude", "f8"),  # m, rms over joints, from one extreme to the other
        ("count", "i8"),  # in its bout, from 1
        ("joint", "i8"),  # that moves most
        (
            "straighter",
            "f8",
        ),  # how much straighter and more upright limbs are where the cycle begins than at the other extreme
        ("resting", "f8"),  # how much more the movement dwells there and is at home, from -1 to 1
        ("turned", "i8"),  # 1 if repetitions begin at the other extreme
    ]
)

HEADER = np.dtype(
    [
        ("joints", "i8"),
        ("root", "i8"),
        ("travels", "i8"),  # 1 if the root's own path is part of the posture
        ("least", "f8"),  # m, rms over joints: what swings by less is not counted
        ("max_pause", "f8"),  # s
        ("chains", "i8"),  # how many there are
        ("chain", "i8", (CHAINS, 3)),  # joints: the end of one bone, what both share, the end of the other
        ("begun", "i8"),  # 1 after the first frame of a take
        ("origin", "f8"),  # s, time of that frame
        ("latest", "f8"),  # s, time of the latest frame
        ("wanted", "f8"),  # s, from when on a frame is taken into a sample
        ("unseen", "i8"),  # coordinates that no frame of the take had
        ("frames", "i8"),  # in the open sample
        ("open", "i8"),  # number of the open sample; as many are complete
        ("looked", "i8"),  # complete samples at the last look
        ("clear", "i8"),  # 1 once some cycles agreed beyond doubt; nothing is told before
        ("dropped", "i8"),  # cycles that are no longer remembered
        ("cycles", "i8"),  # remembered ones
        ("changed", "i8"),  # the first remembered cycle that the last look changed
        ("cycle", CYCLE, (CYCLES,)),
    ]
)

WINNER = np.dtype(
    [("covered", "f8"), ("count", "i8"), ("component", "i8"), ("width", "i8"), ("clear", "i8")],
)

SCRATCH = np.dtype(  # arrays that a look works in; given to kernels, since those that make none are quicker
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
        ("ring", "f4", (SAMPLES,)),  # of scores
        ("winner", WINNER),
    ]
)

GIVEN = (
    "joints",
    "root",
    "travels",
    "least",
    "max_pause",
    "chains",
    "chain",
)  # with the skeleton, for all takes


class Samples(NamedTuple):
    """Views of one performer's array; D = 3 · joints, float32."""

    by_sample: np.ndarray  # (SAMPLES, D), m, ring buffer
    by_coordinate: np.ndarray  # (D, SAMPLES), the same
    axes: np.ndarray  # (COMPONENTS, D), unit vectors
    scores: np.ndarray  # (COMPONENTS, SAMPLES), in the order of time
    smooth: np.ndarray  # (COMPONENTS, SAMPLES), means of neighbours of them
    straight: np.ndarray  # (SAMPLES,) how straight and upright limbs are, 0 to 2, ring buffer as `by_sample`
    sums: np.ndarray  # (D,) of the open sample's frames
    least: np.ndarray  # (D,) of them
    most: np.ndarray  # (D,) of them
    home: np.ndarray  # (D,) m, mean pose of the take's first `HOME` samples
    home_scores: np.ndarray  # (COMPONENTS,) of that pose, as `scores`
    pose: np.ndarray  # (D,) latest known, NaN before a joint was seen


def length(joints: int) -> int:
    """Return how many float32 a performer's samples need."""
    return 3 * joints * (2 * SAMPLES + COMPONENTS + 5) + COMPONENTS * (2 * SAMPLES + 1) + SAMPLES


@inline_kernel(returns_views=True)
def views(memory, joints):
    """Return the parts of a performer's array as `Samples`."""
    d = 3 * joints
    a = d * SAMPLES
    b = 2 * a
    c = b + COMPONENTS * d
    s = c + COMPONENTS * SAMPLES
    t = s + COMPONENTS * SAMPLES
    e = t + SAMPLES
    return Samples(
        memory[:a].reshape((SAMPLES, d)),
        memory[a:b].reshape((d, SAMPLES)),
        memory[b:c].reshape((COMPONENTS, d)),
        memory[c:s].reshape((COMPONENTS, SAMPLES)),
        memory[s:t].reshape((COMPONENTS, SAMPLES)),
        memory[t:e],
        memory[e : e + d],
        memory[e + d : e + 2 * d],
        memory[e + 2 * d : e + 3 * d],
        memory[e + 3 * d : e + 4 * d],
        memory[e + 4 * d : e + 4 * d + COMPONENTS],
        memory[e + 4 * d + COMPONENTS :],
    )


def start(header: np.ndarray, memory: np.ndarray) -> None:
    """Begin a take: forget everything but the skeleton.

    Args:
        header: (1,) `HEADER`.
        memory: (`length(joints)`,) float32.
    """
    kept = {name: header[name].copy() for name in GIVEN}
    header[:] = np.zeros(1, HEADER)
    for name, value in kept.items():
        header[name] = value
    header["unseen"] = 3 * header["joints"]
    memory[:] = 0.0
    memory[-3 * int(header["joints"][0]) :] = np.nan
