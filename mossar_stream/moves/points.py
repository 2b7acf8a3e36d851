"""Points: which axis points upwards in a stream; the kernels that place points are in `points.pxi`."""

from mossar_stream.settings import Up

# Axis and sign of each.
UPWARDS: dict[Up, tuple[int, float]] = {
    "auto": (1, 1.0), "x": (0, 1.0), "y": (1, 1.0), "z": (2, 1.0), "-x": (0, -1.0), "-y": (1, -1.0), "-z": (2, -1.0),
}  # fmt: skip
