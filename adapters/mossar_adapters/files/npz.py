"""Numpy archives: `positions` (n, J, 3), `fps` or `times`, `joint_names`, `parents`, `confidence` (n, J).

Read as a stream, member by member, so that neither a long recording nor a damaged header takes memory.
Nothing is unpickled.
"""

import math
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.assembly import sane_frames, scaled_by_height, skeleton_of
from mossar_adapters.files.errors import FileError, shown
from mossar_adapters.files.missing import without_nobody
from mossar_adapters.files.options import ReadOptions, plausible_rate
from mossar_adapters.files.rates import USUAL_FPS, assumed_rate, rate_of_times
from mossar_adapters.files.rows import CHUNK
from mossar_adapters.files.units import guessed_scale, stated_scale
from mossar_adapters.joint_sets import with_known_parents
from mossar_adapters.source import Recording
from mossar_stream import Frames, constant_times

SMALL = 64 << 20  # bytes, for everything but the positions
_RATES = ("fps", "framerate", "frame_rate", "mocap_framerate", "mocap_frame_rate")
_TIMES = ("timestamps", "time")  # other names of `times` and `joint_names`, if they have the right shape
_NAMES = ("names",)
_TALLEST = 10.0  # m; a larger body is in another unit
_BODY_MODEL = {"poses", "smpl_poses", "body_pose", "pose_body", "fullpose", "betas"}
_DAMAGE = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    OSError,
    ValueError,
    NotImplementedError,
    RuntimeError,
    struct.error,
    tokenize.TokenError,  # of a damaged header
    SyntaxError,
    MemoryError,
)
_PACKED = {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}  # methods of numpy; others may need any memory


class Member(msgspec.Struct, frozen=True):
    """An array in the archive.

    Args:
        name: Without `.npy`.
        shape: From its header.
        dtype: Of its items.
        fortran: Whether the first index runs fastest.
        size: Bytes of its data in the archive's directory.
    """

    name: str
    shape: tuple[int, ...]
    dtype: np.dtype[np.generic]
    fortran: bool
    size: int


def read(path: Path, options: ReadOptions) -> Recording:
    """Read an archive of joint positions."""
    members = _members(path)
    positions = _positions_member(path, members)
    count, joints = positions.shape[:2]
    if count == 0:
        raise FileError(path, f"{shown(positions.name)} has 0 frames")
    times, fps, notes = _clock(path, members, count, options)
    names, parents, root = _joints(path, members, joints)
    confidence = _confidence(path, members, (count, joints))

    def chunks() -> Iterator[Frames]:
        done = 0
        for block in _blocks(path, positions):
            part = slice(done, done + len(block))
            yield sane_frames(
                without_nobody(block), times[part], None if confidence is None else confidence[part]
            )
            done += len(block)

    skeleton = skeleton_of(path, names, parents, root)
    recording = Recording(str(path), skeleton, fps, chunks, notes, count)
    if positions.name == "positions":
        return scaled_by_height(
            recording,
            lambda tall: guessed_scale(options, tall) if tall > _TALLEST else stated_scale(options, 1.0),
        )
    note = f"{shown(positions.name)} is taken for the joint positions"
    recording = msgspec.structs.replace(recording, notes=(note, *notes))
    return scaled_by_height(recording, lambda tall: guessed_scale(options, tall))


def _members(path: Path) -> dict[str, Member]:
    try:
        with zipfile.ZipFile(path) as archive:
            infos = [info for info in archive.infolist() if info.filename.endswith(".npy")]
            if any(info.compress_type not in _PACKED for info in infos):
                raise FileError(path, "it is packed in a way that numpy does not write")
            members = [_member(archive, info) for info in infos[:1000]]
    except _DAMAGE as error:
        raise FileError(path, f"this is no whole .npz archive ({error})") from None
    return {member.name: member for member in members}


def _member(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Member:
    with archive.open(info) as file:
        shape, fortran, dtype = _header(file)
        return Member(info.filename[:-4], shape, dtype, fortran, info.file_size - file.tell())


def _header(file: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[np.generic]]:
    version = np.lib.format.read_magic(file)
    read_header = (
        np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    )
    shape, fortran, dtype = read_header(file)
    return tuple(shape), fortran, dtype


def _positions_member(path: Path, members: dict[str, Member]) -> Member:
    fitting = {
        name: m
        for name, m in members.items()
        if len(m.shape) == 3 and m.shape[2] == 3 and m.shape[1] > 0 and m.dtype.kind in "fiu"
    }
    if "positions" in fitting:
        member = fitting["positions"]
    elif len(fitting) == 1 and "positions" not in members:
        member = next(iter(fitting.values()))
    elif _BODY_MODEL & set(members):
        raise FileError(
            path,
            "it holds SMPL/AMASS body parameters, not joint positions; these need the licensed body model:"
            " compute the joints with it and save them as positions (n, J, 3)",
        )
    else:
        present = ", ".join(f"{name[:40]} {m.shape}" for name, m in list(members.items())[:8])
        raise FileError(
            path, f"there is no array positions of shape (n, J, 3); there are: {present or 'none'}"
        )
    if member.shape[0] * member.shape[1] * 3 * member.dtype.itemsize != member.size:
        raise FileError(
            path, f"{shown(member.name)} is cut off or damaged: its size is not that of {member.shape}"
        )
    if member.fortran and member.size > SMALL:
        raise FileError(
            path, f"{shown(member.name)} is in Fortran order and too large to turn; save it in C order"
        )
    return member


def _blocks(path: Path, member: Member) -> Iterator[NDArray[np.float64]]:
    """Yield (n, J, 3) blocks of up to `CHUNK` frames."""
    if member.fortran:
        with np.errstate(invalid="ignore"):
            whole = _array(path, member).astype(np.float64)
        yield from (whole[i : i + CHUNK] for i in range(0, len(whole), CHUNK))
        return
    frame_size = member.shape[1] * 3 * member.dtype.itemsize
    try:
        with zipfile.ZipFile(path) as archive, archive.open(f"{member.name}.npy") as file:
            _header(file)
            left = member.shape[0]
            while left:
                data = file.read(min(CHUNK, left) * frame_size)
                if len(data) < min(CHUNK, left) * frame_size:
                    raise EOFError("it ends too early")
                block = np.frombuffer(data, member.dtype).reshape(-1, member.shape[1], 3)
                with np.errstate(invalid="ignore"):  # damaged floats may be signalling NaN
                    wide = block.astype(np.float64)
                yield wide
                left -= len(block)
    except _DAMAGE as error:
        raise FileError(path, f"{shown(member.name)} is damaged ({error})") from None


def _array(path: Path, member: Member) -> NDArray[np.generic]:
    """Return a small array as a whole."""
    if member.size > SMALL or member.dtype.hasobject:
        raise FileError(path, f"{shown(member.name)} is too large or holds Python objects")
    if math.prod(member.shape) * member.dtype.itemsize != member.size:
        raise FileError(path, f"{shown(member.name)} is damaged: its size is not that of {member.shape}")
    try:
        with zipfile.ZipFile(path) as archive, archive.open(f"{member.name}.npy") as file:
            array: NDArray[np.generic] = np.lib.format.read_array(file, allow_pickle=False)
            return array
    except _DAMAGE as error:
        raise FileError(path, f"{shown(member.name)} is damaged ({error})") from None


def _clock(
    path: Path, members: dict[str, Member], count: int, options: ReadOptions
) -> tuple[NDArray[np.float64], float | None, tuple[str, ...]]:
    """Return times, rate and notes."""
    stamps = _called(members, "times", _TIMES, count)
    if options.fps is None and stamps is not None:
        times = _array(path, members[stamps])
        if times.shape != (count,) or times.dtype.kind not in "fiu":
            raise FileError(path, f"{shown(stamps)} is not one number for each of {count} frames")
        seconds = times.astype(np.float64)
        if not np.isfinite(seconds).all():
            raise FileError(path, f"{shown(stamps)} holds values that are not finite")
        return seconds, rate_of_times(seconds), ()
    fps, notes = options.fps, tuple[str, ...]()
    for name in _RATES if fps is None else ():
        if name in members:
            fps = _rate(path, members[name])
            break
    if fps is None:
        fps, notes = USUAL_FPS, (assumed_rate("the file does not state it"),)
    return constant_times(count, fps), fps, notes


def _confidence(
    path: Path, members: dict[str, Member], shape: tuple[int, int]
) -> NDArray[np.floating] | None:
    """Return the confidence of each joint, (n, J), None if the file has none."""
    member = members.get("confidence")
    if member is None or member.shape != shape or member.dtype.kind != "f":
        return None
    return _array(path, member).astype(np.float32)


def _called(members: dict[str, Member], name: str, others: tuple[str, ...], count: int) -> str | None:
    """Return the name by which something is in the archive, None if it is not."""
    if name in members:
        return name
    return next((other for other in others if other in members and members[other].shape == (count,)), None)


def _rate(path: Path, member: Member) -> float:
    value = _array(path, member)
    fps = float(value.reshape(-1)[0]) if value.size == 1 and value.dtype.kind in "fiu" else float("nan")
    if not plausible_rate(fps):
        raise FileError(path, f"{shown(member.name)} is no possible rate; set --fps")
    return fps


def _joints(
    path: Path, members: dict[str, Member], count: int
) -> tuple[tuple[str, ...], tuple[int, ...], int]:
    """Return names, parents and root."""
    names = tuple(f"joint{i}" for i in range(count))
    texts = _called(members, "joint_names", _NAMES, count)
    if texts is not None:
        given_names = _array(path, members[texts])
        if given_names.shape != (count,) or given_names.dtype.kind not in "US":
            raise FileError(path, f"{shown(texts)} is not one text for each of {count} joints")
        names = tuple(n.decode("latin-1") if isinstance(n, bytes) else str(n) for n in given_names.tolist())
    parents, root = with_known_parents(names)
    if "parents" in members:
        given_parents = _array(path, members["parents"])
        if given_parents.shape != (count,) or given_parents.dtype.kind not in "iu":
            raise FileError(path, f"'parents' is not one index for each of {count} joints")
        parents = tuple(given_parents.tolist())
        root = root if root >= 0 or -1 not in parents or all(p < 0 for p in parents) else parents.index(-1)
    return names, parents, root
