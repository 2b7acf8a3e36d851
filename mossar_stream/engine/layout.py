"""Layout: the records by which Python tells the loop whose frames it has, and where everything lies."""

import numpy as np

STATION = np.dtype(
    [
        ("limbs", "i8"),
        ("readers", "i8"),
        ("phase", "i8"),  # whether the phase of each frame is asked for
        ("joints", "i8"),  # of all limbs together
        (
            "order",
            "i8",
        ),  # where they begin, bytes: which joint of the performer each is, negative for the middle,
        ("frame", "i8"),  # and where each is in the frame that the body processed last, m
        ("analyse", "i8"),  # address of the function that analyses repetitions
    ],
)
CHANNEL = np.dtype(  # the body's, then those of the limbs
    [
        ("row", "i8"),  # address
        ("row_bytes", "i8"),
        ("first", "i8"),  # of its joints among those of all limbs; -1 of the body
        ("joints", "i8"),
        ("heed", "i8"),  # which analyses of its repetitions are to stop the loop
        ("is_taken", "i8"),  # whether the frame step took the last frame, and did not pass it over
    ],
)
READER = np.dtype(
    [
        ("call", "i8"),  # address of the function
        ("state", "i8"),  # address
        ("state_bytes", "i8"),
        ("store", "i8"),  # address
        ("store_bytes", "i8"),
    ],
)
NO_ANALYSIS, CHANGES, ALL_ANALYSES = range(3)  # in CHANNEL.heed
HEAD = np.dtype(
    [
        ("performers", "i8"),
        ("count", "i8"),  # frames of each; 0 for all there are
        ("performer", "i8"),  # which is next,
        ("frame", "i8"),  # how many of its frames are processed,
        ("stage", "i8"),  # and who is next with the frame: 0 the body, then limbs, readers, the phase
        ("stopped", "i8"),  # why the loop stopped, until that is done
        ("changed", "i8"),  # whether the last analysis of repetitions changed what is counted
    ],
)
SEAT = np.dtype([("station", "i8"), ("begin", "i8")])  # address; first of its frames
HEAD_BYTES, STATION_BYTES, CHANNEL_BYTES = HEAD.itemsize, STATION.itemsize, CHANNEL.itemsize
READER_BYTES = READER.itemsize
TOOLS = np.dtype(
    [
        ("scratch", "i8"),  # where it begins, bytes
        ("scratch_bytes", "i8"),
        ("store", "i8"),  # in which repetitions are analysed
        ("store_bytes", "i8"),
        ("events", "i8"),
        ("events_bytes", "i8"),
    ]
)
TOOLS_BYTES = TOOLS.itemsize
