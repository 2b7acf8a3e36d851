# Which sources this extension was compiled from, and whether the machine can run the other one.

cdef extern from "built_from.h" nogil:
    const char* MOSSAR_BUILT_FROM
    const char* MOSSAR_RECORDS  # the members of structs, see `records.py`

cdef extern from "processor.h" nogil:
    int mossar_has_x86_64_v3()

# The recipe, then a line for each source: checksum and path below `mossar_stream`. See `choosing.py`.
BUILT_FROM = MOSSAR_BUILT_FROM.decode()


def has_x86_64_v3() -> bool:
    """Return whether the processor has the instructions of x86-64-v3, and the system saves its registers."""
    return mossar_has_x86_64_v3() != 0
