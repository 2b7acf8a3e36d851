"""Layout: how the bytes of followed examples, and of a performer who is followed, are laid out."""

import numpy as np

PERIOD = 1.0 / 15.0  # s between two samples of a stream, and between two phases of an example
MOST_PHASES = 150  # 10 s; of longer examples a phase lasts several samples
LANES = 8  # bones that are computed at once
LAYERS = 2  # of cells: those that have come on, and those that have stayed once
RECENT = 16  # samples of which the progress is remembered, for the tempo
TEMPO_SAMPLES = 15  # over which it is taken: 1 s
RING = 320  # samples that are remembered, for the range

HEAD = np.dtype(
    [
        ("points", "i8"),
        ("bones", "i8"),
        ("lanes", "i8"),  # bones, padded
        ("examples", "i8"),
        ("moves", "i8"),
        ("left", "i8"),  # points of the hips, -1 if they are not known
        ("right", "i8"),
        ("axis", "i8"),  # that points upwards
        ("sign", "f8"),
        ("stride", "i8"),  # samples that a place of the ring stands for
    ]
)
HEAD_BYTES = HEAD.itemsize
POINT = np.dtype(
    [("one", "i8"), ("other", "i8")]
)  # two joints in whose middle it lies; -1 for the mean of all
BONE = np.dtype([("begin", "i8"), ("end", "i8"), ("limb", "i8")])  # points
EXAMPLE = np.dtype(
    [
        ("move", "i8"),
        ("phases", "i8"),
        ("stride", "i8"),  # samples that a phase lasts
        ("rows", "i8"),  # where its directions begin, floats
        ("dearest", "f8"),  # cost from which a way is not the move
        ("memory", "i8"),  # where its cells begin in the memory of a performer, bytes
    ]
)
MOVE = np.dtype(
    [
        ("active", "i8"),  # whether it is being made
        ("happened", "i8"),  # at the frame that the kernel stopped at
        ("number", "i8"),  # of the latest performance
        ("count", "i8"),  # done in the take
        ("rev", "i8"),
        ("example", "i8"),  # of which the numbers are
        ("start", "f8"),  # s
        ("time", "f8"),  # s, of the sample that the numbers are of
        ("seen", "f8"),  # s, when it was last followed well
        ("told", "f8"),  # s, when an event was last due
        ("progress", "f8"),
        ("cost", "f8"),  # of the way that leads, mean square of the chord
        ("tempo", "f8"),
        ("certainty", "f8"),
        ("best", "f8"),  # cost of the best end that is not decided yet, inf if there is none
        ("best_start", "f8"),  # s
        ("best_time", "f8"),  # s
        ("best_example", "i8"),
        ("from_time", "f8"),  # s, no performance begins before this
        ("recent", "f4", (RECENT,)),  # progress at the last samples
        ("recents", "i8"),
    ]
)
STATE = np.dtype(
    [
        ("due", "f8"),  # -inf: samples lie between two frames, so every frame is needed; see readers.py
        ("frames", "i8"),  # since the last gap
        ("samples", "i8"),  # since the last gap
        ("time", "f8"),  # s, of the last frame
        ("next", "f8"),  # s, when the next sample is due
        ("sampled", "f8"),  # s, of the last sample
        ("across", "f8", (2,)),  # m, from hip to hip, slowly following
        ("every", "f8"),  # s, setting `follow_every`
        ("number", "i8"),  # of the latest performance of the take
        ("happened", "i8"),  # whether anything did
        ("poses", "i8"),  # in the ring, since the last gap
    ]
)
STATE_BYTES, MOVE_BYTES, EXAMPLE_BYTES = STATE.itemsize, MOVE.itemsize, EXAMPLE.itemsize
POINT_BYTES, BONE_BYTES = POINT.itemsize, BONE.itemsize


def example_floats(phases: int, lanes: int) -> int:
    """Return the numbers that the directions of an example take."""
    return phases * 3 * lanes


def head_memory(points: int, lanes: int, moves: int) -> int:
    """Return the bytes of a performer besides the cells of examples."""
    floats = 2 * 3 * points + 3 * lanes + 2 * moves * lanes + RING * 3 * lanes + 2 * moves * 3 * lanes
    return STATE_BYTES + moves * MOVE_BYTES + 4 * (floats + floats % 2)


def example_memory(phases: int, lanes: int) -> int:
    """Return the bytes of an example's cells in the memory of a performer."""
    floats = LAYERS * phases * (2 + lanes) + phases * (1 + lanes)
    return 8 * LAYERS * phases + 4 * (floats + floats % 2)
