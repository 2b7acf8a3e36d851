"""MSRC-12: Kinect gestures, one row of 81 numbers per frame: time stamp, then x y z and state of 20 joints.

Times are in microseconds, coordinates in metres. Before a player is found all is zero.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mossar_adapters.files.assembly import in_metres, sane_frames, skeleton_of
from mossar_adapters.files.cells import numbers
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.missing import without_zeros
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.rates import rate_of_times
from mossar_adapters.files.rows import Block, cut_note, survey
from mossar_adapters.files.units import stated_scale
from mossar_adapters.joint_sets import KINECT_20
from mossar_adapters.source import Recording
from mossar_stream import Frames, constant_times

WIDTH = 81
MICROSECOND = 1e-6


def splitted(text: str) -> list[str]:
    """Return the numbers of a row; some copies have commas instead of spaces."""
    return text.replace(",", " ").split()


def read(path: Path, options: ReadOptions) -> Recording:
    """Read a gesture recording."""
    rows = survey(path, 1, splitted, WIDTH)

    def frames_of(block: Block) -> Frames:
        values = numbers(block.cells, path, block.lines)
        times = values[:, 0] * MICROSECOND
        for i in np.flatnonzero(~np.isfinite(times)):
            raise FileError(path, "the row has no time", block.lines[i])
        if options.fps is not None:
            times = constant_times(len(times), options.fps, block.start)
        return sane_frames(without_zeros(values[:, 1:].reshape(-1, 20, 4)[:, :, :3]), times)

    def chunks() -> Iterator[Frames]:
        return map(frames_of, rows.blocks())

    fps = options.fps or rate_of_times(frames_of(next(rows.blocks())).times)
    skeleton = skeleton_of(path, KINECT_20.names, KINECT_20.parents, KINECT_20.root)
    recording = Recording(str(path), skeleton, fps, chunks, cut_note(rows), rows.count)
    return in_metres(recording, stated_scale(options, 1.0))
