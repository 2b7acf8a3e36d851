"""Face: further functions for Python, and its records and constants."""

cdef object NP_DOUBLE = __import__("numpy").dtype("float64")


def set_middle(cnp.ndarray row, cnp.ndarray middle, /):
    """Set the middle of the joints of the frame that a body processed last; see `put_middle`.

    Args:
        row: Bytes of the performer.
        middle: (3,) float32 m, set.
    """
    put_middle(<Row*>cnp.PyArray_DATA(row), <float*>cnp.PyArray_DATA(middle))


def pad(int64_t joints, /):
    """Return the number of padded joints for a number of joints."""
    return (joints + PADDING - 1) // PADDING * PADDING


# The numpy type of each record; the members come from the declarations.
RECORDS = record_types(MOSSAR_RECORDS.decode(), {
    "Plan": sizeof(Plan),
    "Row": sizeof(Row),
    "Clock": sizeof(Clock),
    "Key": sizeof(Key),
    "Mark": sizeof(Mark),
    "Memo": sizeof(Memo),
    "Bout": sizeof(Bout),
    "Note": sizeof(Note),
    "Event": sizeof(Event),
    "Counters": sizeof(Counters),
    "Measure": sizeof(Measure),
    "Counting": sizeof(Counting),
    "Periods": sizeof(Periods),
    "Labels": sizeof(Labels),
    "Steps": sizeof(Steps),
})

# Constants that Python needs, too; `kernels` offers them by name.
CONSTANTS = {
    "ANALYSIS_INTERVAL": ANALYSIS_INTERVAL,
    "BOUTS": BOUTS,
    "CHAINS": CHAINS,
    "CYCLES": CYCLES,
    "DECIDE": DECIDE,
    "EARLIER": EARLIER,
    "EARLIER_IN_NOISE": EARLIER_IN_NOISE,
    "LABELLED_LATE": LABELLED_LATE,
    "LEAST_WAY": LEAST_WAY,
    "LEAST_WAY_OF_ANKLES": LEAST_WAY_OF_ANKLES,
    "LINES": LINES,
    "LIVE": LIVE,
    "LONGEST_SILENCE": LONGEST_SILENCE,
    "MARGIN": MARGIN,
    "NOTED_CANDIDATES": NOTED_CANDIDATES,
    "NOTED_LATE": NOTED_LATE,
    "NOT_KEPT": NOT_KEPT,
    "PADDING": PADDING,
    "PAGE": PAGE,
    "PAGE_SIZE": PAGE_SIZE,
    "POSE_X": POSE_X,
    "RANK": RANK,
    "SPACING": SPACING,
    "SPEED_WINDOW": SPEED_WINDOW,
    "TIME_ROUNDING": TIME_ROUNDING,
}
