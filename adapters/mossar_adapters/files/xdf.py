"""XDF: Lab Streaming Layer recordings; the stream of type MoCap.

Channels are found by their labels as in tables (`hip_x`, `hip_y`, `hip_z`). The structure is checked before
the library reads it, since a damaged count would make it take memory without limit.
"""

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np

from mossar_adapters.files.assembly import in_metres, sane_frames, scaled_by_height, skeleton_of
from mossar_adapters.files.columns import find_columns
from mossar_adapters.files.errors import FileError, shown
from mossar_adapters.files.options import METRES, ReadOptions, plausible_rate
from mossar_adapters.files.rates import rate_of_times
from mossar_adapters.files.rows import CHUNK
from mossar_adapters.files.units import given, guessed
from mossar_adapters.joint_sets import with_known_parents
from mossar_adapters.source import Recording
from mossar_stream.frames import Frames, constant_times

MAGIC = b"XDF:"
_TYPES = {"mocap", "motion capture", "motioncapture", "mocap data"}
_UNITS = {**METRES, "meters": 1.0, "metres": 1.0, "millimeters": 1e-3, "centimeters": 1e-2}
_SAMPLES = 3  # tag of chunks that hold samples
