"""Force plates of C3D files: when something comes onto a plate and leaves it."""

import itertools
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.c3d import Layout, layout_of, rate_of
from mossar_adapters.files.c3d_parameters import Value, floats, integers, read_parameters
from mossar_adapters.files.errors import FileError

LOADED = 20.0  # N, from which a plate is stood on
LEAST = 0.1  # s that a contact lasts


def contacts(path: Path) -> dict[str, list[float]]:
    """Return the times at which plates began and ceased to be loaded, s from the first frame, as `strike` and `off`.

    A contact that has begun before the first frame, or lasts beyond the last, has no such end.

    Args:
        path: A C3D file; one without force plates has no contacts.

    Raises:
        FileError: If it is damaged.
    """
    header, machine, parameters = read_parameters(path)
    channels, rate = _vertical(parameters), _one(parameters, "ANALOG:RATE")
    found: dict[str, list[float]] = {"strike": [], "off": []}
    layout = layout_of(path, header, machine, parameters)
    per_frame = header.analog // max(1, int(_one(parameters, "ANALOG:USED")))
    if not channels or rate <= 0 or per_frame < 1:
        return found
    forces = _forces(path, header.analog // per_frame, layout, parameters, channels)
    step = 1.0 / (per_frame * rate_of(path, header, parameters))
    for force in forces.T:
        loaded = np.abs(force - np.median(force[np.abs(force) <= np.quantile(np.abs(force), 0.25)])) > LOADED
        edges = np.flatnonzero(np.diff(loaded.astype(int))) + 1
        bounds = [0, *edges.tolist(), len(loaded)]
        for begin, end in itertools.pairwise(bounds):
            if loaded[begin] and (end - begin) * step >= LEAST:
                found["strike"] += [begin * step] if begin else []
                found["off"] += [end * step] if end < len(loaded) else []
    return {status: sorted(times) for status, times in found.items()}


def _vertical(parameters: dict[str, Value]) -> list[int]:
    """Return the channels of the vertical forces of plates of types 1 and 2, from 0."""
    used = int(_one(parameters, "FORCE_PLATFORM:USED"))
    table = np.asarray(parameters.get("FORCE_PLATFORM:CHANNEL", ()), np.float64)
    kinds = np.asarray(parameters.get("FORCE_PLATFORM:TYPE", ()), np.float64)
    if not used or len(table) % used or len(kinds) < used:
        return []
    rows = table.reshape(used, -1)
    return [
        int(row[2]) - 1 for row, kind in zip(rows, kinds, strict=False) if kind in {1, 2} and len(row) > 2
    ]


def _forces(
    path: Path, channels: int, layout: Layout, parameters: dict[str, Value], wanted: list[int]
) -> NDArray[np.float64]:
    """Return (samples, plates) N."""
    scales = np.asarray(parameters.get("ANALOG:SCALE", ()), np.float64)
    offsets = np.asarray(parameters.get("ANALOG:OFFSET", ()), np.float64)
    general = _one(parameters, "ANALOG:GEN_SCALE") or 1.0
    if max(wanted) >= min(channels, len(scales), len(offsets)):
        raise FileError(path, "a force plate has a channel that is not in the file")
    size, points = layout.frame_size, layout.points
    with path.open("rb") as file:
        file.seek(layout.start)
        data = file.read(layout.count * size)
    data = data[: len(data) // size * size]
    machine, integer = layout.machine, layout.integer
    values = integers(data, machine).astype(np.float64) if integer else floats(data, machine)
    rows = values.reshape(len(data) // size, -1)[:, 4 * points :].reshape(-1, channels)
    forces: NDArray[np.float64] = (rows[:, wanted] - offsets[wanted]) * scales[wanted] * general
    return forces


def _one(parameters: dict[str, Value], name: str) -> float:
    value = parameters.get(name)
    return float(value[0]) if isinstance(value, np.ndarray) and len(value) else 0.0
