"""Layout: how the bytes of followed examples, and of a performer who is followed, are laid out."""

import numpy as np

PERIOD = 1.0 / 15.0  # s between two samples of a stream, and between two phases of an example
MOST_PHASES = 150  # 10 s; of longer examples a phase lasts several samples
LANES = 8  # phases that are computed at once
LAYERS = 2  # of cells: ways that have come on with the latest sample, and those that have stayed
LONGER = 16  # samples beyond twice an example that are remembered
RECENT_SAMPLES = 16  # samples of which the progress is remembered, for the tempo
TEMPO_SAMPLES = 15  # over which it is taken: 1 s

# What is reported of a move, as numbers; then the deviation of each limb.
REPORT = (
    "number",
    "rev",
    "count",
    "start",
    "time",
    "progress",
    "tempo",
    "deviation",
    "joint",
    "example",
    "cost",
    "gain",
    "went",
    "residual",
)

BANK_HEAD = np.dtype(
    [
        ("points", "i8"),
        ("bones", "i8"),
        ("examples", "i8"),
        ("moves", "i8"),
        ("limbs", "i8"),  # that have bones
        ("left", "i8"),  # points of the hips, then of the shoulders; -1 if they are not known
        ("right", "i8"),
        ("left_shoulder", "i8"),
        ("right_shoulder", "i8"),
        ("axis", "i8"),  # that points upwards
        ("sign", "f8"),
        ("strides", "i8"),  # how many different ones the examples have
        ("ring", "i8"),  # samples that are remembered of each
        ("phases", "i8"),  # of the longest example, padded
    ]
)
BANK_HEAD_BYTES = BANK_HEAD.itemsize
BONE_POINT = np.dtype(
    [("one", "i8"), ("other", "i8")]
)  # two joints in whose middle it lies; -1 for the mean of all
BONE = np.dtype([("begin", "i8"), ("end", "i8"), ("limb", "i8")])  # points; limb -1 for none
FOLLOWED = np.dtype(
    [
        ("move", "i8"),
        ("phases", "i8"),
        ("padded", "i8"),  # phases, padded
        ("stride", "i8"),  # samples that a phase lasts
        ("ring", "i8"),  # which of the rings has its samples
        ("still", "f8"),  # mean square of the chord between its bones and their mean directions
        ("dear", "f8"),  # the same, no chord counted beyond `CAP`: what costs are relative to
        ("farthest", "f8"),  # largest mean square of the chord between a phase and the first one
        ("rows", "i8"),  # where its directions begin, floats
        ("memory", "i8"),  # where its cells begin in the memory of a performer, bytes
    ]
)
MOVE = np.dtype(
    [
        ("active", "i8"),  # whether it is being made
        ("number", "i8"),  # of the latest performance
        ("count", "i8"),  # done in the take
        ("rev", "i8"),
        ("example", "i8"),  # of which the numbers are
        ("layer", "i8"),  # where the way is that they are of
        ("phase", "i8"),
        ("first", "i8"),  # its first and its last sample
        ("last", "i8"),
        ("start", "f8"),  # s
        ("time", "f8"),  # s, of the sample that the numbers are of
        ("seen", "f8"),  # s, when it was last followed well
        ("reported", "f8"),  # s, when an event was last due
        ("progress", "f8"),
        ("cost", "f8"),  # of the way, relative to a performer who stands still
        ("gain", "f8"),  # how far the example's movement is found in the stream: 1 for all of it
        ("went", "f8"),  # how far the performer has gone from the first pose, relative to the example
        ("residual", "f8"),  # cost of what is left once constant differences are taken away
        ("best", "f8"),  # rank of the best end that is not decided yet, inf if there is none
        ("best_gain", "f8"),
        ("best_first", "i8"),  # sample
        ("best_last", "i8"),
        ("best_layer", "i8"),
        ("best_example", "i8"),
        ("done", "f8"),  # rank of the latest performance that was done, inf if there is none
        ("done_first", "i8"),  # its samples
        ("done_last", "i8"),
        ("recent", "f4", (RECENT_SAMPLES,)),  # progress at the last samples
        ("recents", "i8"),
    ]
)
FOLLOWING_STATE = np.dtype(
    [
        ("due", "f8"),  # -inf: samples lie between two frames, so every frame is needed; see readers.py
        ("frames", "i8"),  # since the last gap
        ("samples", "i8"),  # since the last gap
        ("time", "f8"),  # s, of the last frame
        ("next", "f8"),  # s, when the next sample is due
        ("sampled", "f8"),  # s, of the last sample
        ("facing", "f8", (2,)),  # x and z, slowly following
        ("every", "f8"),  # s, setting `follow_every`
        ("number", "i8"),  # of the latest performance of the take
        ("happened", "i8"),  # whether anything did
    ]
)
FOLLOWING_STATE_BYTES, MOVE_BYTES, FOLLOWED_BYTES = FOLLOWING_STATE.itemsize, MOVE.itemsize, FOLLOWED.itemsize
BONE_POINT_BYTES, BONE_BYTES = BONE_POINT.itemsize, BONE.itemsize


def padded(phases: int) -> int:
    """Return how many numbers the phases of an example take."""
    return -(-phases // LANES) * LANES


def ring_size(phases: int) -> int:
    """Return how many samples must be remembered to follow so many phases at half their tempo."""
    return 2 * phases + LONGER


def example_floats(phases: int, bones: int) -> int:
    """Return the numbers that an example takes: (bones, 3, padded) directions, then their means, (bones, 3)."""
    return 3 * bones * (padded(phases) + 1)


def head_memory(head: np.void) -> int:
    """Return the bytes of a performer besides the cells of examples."""
    points, bones, moves = int(head["points"]), int(head["bones"]), int(head["moves"])
    ring, strides, phases = int(head["ring"]), int(head["strides"]), int(head["phases"])
    floats = 7 * points + 3 * bones + 2 * phases + moves * 7 * bones + strides * ring * 3 * bones + 3 * bones
    whole = 4 * ring
    reports = moves * (len(REPORT) + int(head["limbs"]) + 1)
    hidden = -(-strides * ring * bones // 8) * 8
    return (
        FOLLOWING_STATE_BYTES
        + moves * MOVE_BYTES
        + 8 * reports
        + 4 * (floats + whole + (floats + whole) % 2)
        + hidden
    )


def example_memory(phases: int) -> int:
    """Return the bytes of an example's cells in the memory of a performer."""
    steps = ring_size(phases) * phases
    return 4 * 4 * LAYERS * phases + -(-steps // 8) * 8
