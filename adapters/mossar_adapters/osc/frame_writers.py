"""Writers of a frame of joint positions, one for each OSC profile.

A writer turns one frame into messages; the sink bundles and sends them.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.address import Address
from mossar_adapters.joint_sets import with_known_parents
from mossar_adapters.osc.encode import encode
from mossar_adapters.osc.profiles.generic import checked_args, checked_pattern
from mossar_adapters.osc.profiles.osceleton import FIELD
from mossar_adapters.source import Meta

Positions = NDArray[np.float32]  # (J, 3) metres, NaN where missing
Confidence = NDArray[np.float32] | None  # (J,)
Writer = Callable[[Meta, int, float, Positions, Confidence], list[bytes]]  # meta, seq, time


def mossar_meta(meta: Meta) -> bytes:
    """Return the message that announces a performer in profile `mossar`."""
    names, root = meta.skeleton.names, meta.skeleton.root
    known = with_known_parents(names)[1] == root
    tags = "s" * (1 + len(names)) + ("" if known else "i")
    return encode("/mossar/meta", tags, meta.performer, *names, *(() if known else (root,)))


def mossar(meta: Meta, seq: int, time: float, positions: Positions, _: Confidence) -> list[bytes]:
    """Write a frame of profile `mossar`."""
    blob = positions.astype(">f4").tobytes()
    return [encode("/mossar/frame", "sidb", meta.performer, seq, time, blob)]


def osceleton(meta: Meta, _seq: int, _time: float, positions: Positions, _: Confidence) -> list[bytes]:
    """Write `/joint` messages with coordinates as shares of the sensor's field."""
    person = _number(meta.performer)
    shares = positions / np.array(FIELD)
    return [encode("/joint", "sifff", name, person, *map(float, xyz)) for name, xyz in _present(meta, shares)]


def kinectv2(meta: Meta, _seq: int, _time: float, positions: Positions, conf: Confidence) -> list[bytes]:
    """Write `/bodies/<id>/joints/<name>` messages."""
    person = _number(meta.performer)
    written = []
    for i, name in enumerate(meta.skeleton.names):
        missing = bool(np.isnan(positions[i]).any())
        share = 0.0 if missing else 1.0 if conf is None else float(conf[i])
        state = "Tracked" if share > 0.75 else "Inferred" if share > 0 else "NotTracked"
        xyz = (0.0, 0.0, 0.0) if missing else map(float, positions[i])
        written.append(encode(f"/bodies/{person}/joints/{_part(name)}", "fffs", *xyz, state))
    return written


def nimate(meta: Meta, _seq: int, _time: float, positions: Positions, _: Confidence) -> list[bytes]:
    """Write `/skeleton_<joint>` messages; several performers stand before the joint."""
    person = "" if meta.performer == "p1" else f"/{_part(meta.performer)}"
    return [
        encode(f"{person}/skeleton_{_part(name)}", "fff", *map(float, xyz))
        for name, xyz in _present(meta, positions)
    ]


def flat(meta: Meta, _seq: int, _time: float, positions: Positions, conf: Confidence) -> list[bytes]:
    """Write one array `/pose` of x y z, or of x y z confidence."""
    rows = positions if conf is None else np.column_stack((positions, conf))
    address = "/pose" if meta.performer == "p1" else f"/{_part(meta.performer)}/pose"
    return [encode(address, "f" * rows.size, *map(float, rows.ravel()))]


def generic(address: Address) -> Writer:
    """Return a writer for the pattern and arguments that the user gives.

    Raises:
        SettingsError: If they cannot be used.
    """
    pattern, args = checked_pattern(address), checked_args(address)

    def write(meta: Meta, _seq: int, _time: float, positions: Positions, conf: Confidence) -> list[bytes]:
        written = []
        for i, name in enumerate(meta.skeleton.names):
            if np.isnan(positions[i]).any():
                continue
            values: dict[str, float | str] = dict(zip("xyz", map(float, positions[i]), strict=True))
            values |= {"c": 1.0 if conf is None else float(conf[i]), "j": name, "p": meta.performer, "_": 0.0}
            place = pattern.replace("{performer}", _part(meta.performer)).replace("{joint}", _part(name))
            tags = "".join("s" if letter in "jp" else "f" for letter in args)
            written.append(encode(place, tags, *(values[letter] for letter in args)))
        return written

    return write


def _present(meta: Meta, positions: NDArray[np.floating]) -> Sequence[tuple[str, NDArray[np.floating]]]:
    present = np.isfinite(positions).all(axis=1)
    return [(name, positions[i]) for i, name in enumerate(meta.skeleton.names) if present[i]]


def _number(performer: str) -> int:
    """Return a number for a performer: its own digits, else 1."""
    digits = "".join(c for c in performer if c.isascii() and c.isdigit())
    return int(digits[:9]) if digits else 1


def _part(name: str) -> str:
    """Return a name as part of an OSC address."""
    return "".join("_" if c in " #*,/?[]{}" else c for c in name)
