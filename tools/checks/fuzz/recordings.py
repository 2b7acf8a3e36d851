"""Small recordings of every format: a person 1.7 m tall, hip, knee, foot and head, who walks along z."""

import io
import json
import struct
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mossar_adapters.files import MskWriter
from mossar_adapters.source import Meta
from mossar_stream import Frames, Skeleton

FRAMES = 30
JOINTS = ("hip", "knee", "foot", "head")


def walk(frames: int = FRAMES) -> NDArray[np.float64]:
    """Return (frames, 4, 3) metres."""
    person = np.array([[0.01, 1.0, 0], [0.02, 0.5, 0], [0.03, 0.01, 0.1], [0.04, 1.71, 0]])
    return person + np.arange(frames)[:, None, None] * [0, 0, 0.01] + [0, 0, 0.5]


def bvh(frames: int = FRAMES, ends: str = "\n") -> bytes:
    """Return a skeleton of five joints and its rotations."""
    head = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Leg
  {
    OFFSET 10 0 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 -90 0
    }
  }
  JOINT Neck
  {
    OFFSET 0 60 0
    CHANNELS 3 Xrotation Yrotation Zrotation
    End Site
    {
      OFFSET 0 20 0
    }
  }
}
MOTION
"""
    rows = [f"0 90 {i} 0 0 {i} 5 {i} 0 0 {i} 0" for i in range(frames)]
    text = head + f"Frames: {frames}\nFrame Time: 0.0333333\n" + "\n".join(rows) + "\n"
    return text.replace("\n", ends).encode()


ASF = b"""# a skeleton
:version 1.10
:name test
:units
  mass 1.0
  length 0.45
  angle deg
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name leg
     direction 0 -1 0
     length 15.9
     axis 0 0 20 XYZ
     dof rx rz
     limits (-160.0 20.0)
            (-70.0 70.0)
  end
  begin
     id 2
     name spine
     direction 0 1 0
     length 14.2
     axis 0 0 0 XYZ
  end
:hierarchy
  begin
    root leg spine
  end
"""


def amc(frames: int = FRAMES) -> bytes:
    """Return rotations for `ASF`."""
    rows = [f"{i + 1}\nroot 0 16 {i * 0.1} 0 {i} 0\nleg {i} {-i}\n" for i in range(frames)]
    return ("#!OML:ASF test\n:FULLY-SPECIFIED\n:DEGREES\n" + "".join(rows)).encode()


def npz(frames: int = FRAMES, **more: Any) -> bytes:
    """Return a numpy archive."""
    arrays = {
        "positions": walk(frames),
        "fps": 60.0,
        "joint_names": np.array(JOINTS),
        "parents": [-1, 0, 1, 0],
    }
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **{**arrays, **more})
    return buffer.getvalue()


def csv(frames: int = FRAMES) -> bytes:
    """Return our own table."""
    head = "# fps=60 unit=m root=hip parents=-1,0,1,0\ntime," + ",".join(
        f"{j}.{a}" for j in JOINTS for a in "xyz"
    )
    rows = [
        ",".join([f"{i / 60:.4f}", *(f"{v:.5f}" for v in frame.ravel())])
        for i, frame in enumerate(walk(frames))
    ]
    return ("\n".join([head, *rows]) + "\n").encode()


def jsonl(frames: int = FRAMES) -> bytes:
    """Return frames as JSON lines."""
    meta = {"v": 1, "type": "meta", "performer": "p1", "names": JOINTS, "parents": [-1, 0, 1, 0], "root": 0}
    maps = [
        {
            "v": 1,
            "type": "frame",
            "performer": "p1",
            "seq": i,
            "t": i / 60,
            "shape": [4, 3],
            "xyz": frame.tolist(),
        }
        for i, frame in enumerate(walk(frames))
    ]
    return "".join(json.dumps(found) + "\n" for found in [meta | {"fps": 60}, *maps]).encode()


def msk(frames: int = FRAMES) -> bytes:
    """Return our own recording."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.msk"
        with MskWriter(path) as writer:
            writer.write(Meta("p1", Skeleton(JOINTS, (-1, 0, 1, 0)), 60.0))
            writer.write(Frames(walk(frames).astype(np.float32), np.arange(frames) / 60))
        return path.read_bytes()


def trc(frames: int = FRAMES) -> bytes:
    """Return markers in millimetres."""
    head = (
        "PathFileType\t4\t(X/Y/Z)\ttest.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate"
    )
    head += f"\tOrigDataStartFrame\tOrigNumFrames\n60\t60\t{frames}\t4\tmm\t60\t1\t{frames}\nFrame#\tTime\t"
    head += (
        "\t\t\t".join(JOINTS)
        + "\t\t\n\t\t"
        + "\t".join(f"{a}{k}" for k in range(1, 5) for a in "XYZ")
        + "\n\n"
    )
    rows = [
        "\t".join([f"{i + 1}", f"{i / 60:.5f}", *(f"{v * 1000:.4f}" for v in frame.ravel())]) + "\n"
        for i, frame in enumerate(walk(frames))
    ]
    return (head + "".join(rows)).encode()


def motive(frames: int = FRAMES) -> bytes:
    """Return an OptiTrack skeleton."""
    kinds = ["", "Type"] + ["Bone"] * 28
    names = ["", "Name"] + [f"anna:{bone}" for bone in ("anna", "Thigh", "Foot", "Head") for _ in range(7)]
    parents = ["", "Parent"] + [p for p in ("Root", "anna:anna", "anna:Thigh", "anna:anna") for _ in range(7)]
    what = ["", ""] + (["Rotation"] * 4 + ["Position"] * 3) * 4
    axes = ["Frame", "Time (Seconds)"] + list("XYZWXYZ") * 4
    first = ["Format Version", "1.25", "Take Name", "t", "Export Frame Rate", "60", "Total Exported Frames"]
    lines = [[*first, str(frames), "Length Units", "Meters"], [""] * 30, kinds, names, parents, what, axes]
    for i, frame in enumerate(walk(frames)):
        lines.append(
            [f"{i}", f"{i / 60:.5f}"] + [v for p in frame for v in ["0", "0", "0", "1", *map(str, p)]]
        )
    return ("\ufeff" + "\r\n".join(",".join(line) for line in lines) + "\r\n").encode()


def qtm(frames: int = FRAMES) -> bytes:
    """Return Qualisys markers."""
    head = f"NO_OF_FRAMES\t{frames}\nNO_OF_CAMERAS\t8\nNO_OF_MARKERS\t4\nFREQUENCY\t60\nDATA_INCLUDED\t3D\n"
    head += "MARKER_NAMES\t" + "\t".join(JOINTS) + "\n"
    return (
        head + "".join("\t".join(f"{v * 1000:.3f}" for v in f.ravel()) + "\n" for f in walk(frames))
    ).encode()


def msrc12(frames: int = FRAMES) -> bytes:
    """Return a Kinect gesture."""
    rows = [b"1000000 " + b"0 " * 79 + b"0\n"]
    for i in range(frames):
        joints = np.zeros((20, 4))
        joints[:, :3] = np.repeat(walk(frames)[i], 5, axis=0) + np.arange(20)[:, None] * 0.001
        rows.append(f"{1033000 + 33000 * i} {' '.join(f'{v:.5f}' for v in joints.ravel())}\n".encode())
    return b"".join(rows)


def ntu(frames: int = FRAMES) -> bytes:
    """Return a Kinect body."""
    lines = [str(frames)]
    for i in range(frames):
        lines += ["1", "72057594037931101 0 1 1 1 1 0 0.01 0.02 2", "25"]
        points = np.repeat(walk(frames)[i], 7, axis=0)[:25] + np.arange(25)[:, None] * 0.001
        lines += [
            f"{x:.5f} {y:.5f} {z:.5f} 1 2 3 4 0 0 0 1 {2 - (k == 3)}" for k, (x, y, z) in enumerate(points)
        ]
    return ("\n".join(lines) + "\n").encode()


def mediapipe(frames: int = FRAMES) -> bytes:
    """Return world landmarks."""
    names = ("left_hip", "left_knee", "left_ankle", "nose")
    pictures = [
        {
            "timestamp_ms": 40 * i,
            "pose_world_landmarks": [
                {"x": x, "y": -y, "z": -z, "visibility": 0.9, "name": name}
                for (x, y, z), name in zip(frame.tolist(), names, strict=True)
            ],
        }
        for i, frame in enumerate(walk(frames))
    ]
    return json.dumps({"frames": pictures}).encode()


def openpose(dimensions: int = 3) -> bytes:
    """Return one person of one frame."""
    values = [v for point in walk(1)[0][:, :dimensions] for v in [*point, 0.9]]
    return json.dumps({"version": 1.3, "people": [{f"pose_keypoints_{dimensions}d": values}]}).encode()


def c3d(
    frames: int = FRAMES,
    machine: int = 84,
    *,
    integer: bool = False,
    first: int = 1,
    labels: Sequence[str] = JOINTS,
    unit: str = "mm",
    positions: NDArray[np.float64] | None = None,
) -> bytes:
    """Return a C3D file in the byte order of Intel (84), DEC (85) or SGI (86), of a walking person or of other (n, J, 3) m."""
    frames = frames if positions is None else len(positions)
    order = ">" if machine == 86 else "<"

    def real(values: ArrayLike) -> bytes:
        if machine == 85:
            halves = (np.asarray(values, "<f4") * 4).view("<u2").reshape(-1, 2)[:, ::-1]
            return np.ascontiguousarray(halves).tobytes()
        return np.asarray(values, f"{order}f4").tobytes()

    def parameter(name: str, kind: int, dimensions: Sequence[int], data: bytes) -> bytes:
        body = bytes([kind & 255, len(dimensions), *dimensions]) + data + b"\0"
        return bytes([len(name), 1]) + name.encode() + struct.pack(f"{order}h", len(body) + 2) + body

    scale = 0.1 if integer else -0.1
    header = bytes([2, 0x50]) + struct.pack(f"{order}5H", len(labels), 0, first, first + frames - 1, 0)
    header += real([scale]) + struct.pack(f"{order}2H", 4, 1) + real([60])
    width = max(map(len, labels))
    section = bytes([1, 0x50, 2, machine, 5, 255]) + b"POINT" + struct.pack(f"{order}h", 3) + b"\0"
    section += parameter("RATE", 4, [], real([60]))
    section += parameter("UNITS", -1, [len(unit)], unit.encode())
    section += parameter("LABELS", -1, [width, len(labels)], "".join(x.ljust(width) for x in labels).encode())
    data = np.zeros((frames, len(labels), 4))
    moving = np.resize(walk(frames), (frames, len(labels), 3)) if positions is None else positions
    data[:, :, :3] = moving * 1000
    data[0, 1, 3] = -1
    if integer:
        data[:, :, :3] /= scale
    body = np.round(data).astype(f"{order}i2").tobytes() if integer else real(data.ravel())
    return header.ljust(512, b"\0") + section.ljust(1024, b"\0") + body


def xdf(frames: int = FRAMES) -> bytes:
    """Return a stream of Lab Streaming Layer."""

    def varlen(count: int) -> bytes:
        return b"\x04" + struct.pack("<I", count)

    def chunk(tag: int, content: bytes) -> bytes:
        return varlen(len(content) + 2) + struct.pack("<H", tag) + content

    channels = "".join(
        f"<channel><label>{j}_{a}</label><unit>m</unit></channel>" for j in JOINTS for a in "xyz"
    )
    header = "<info><name>Body</name><type>MoCap</type><channel_count>12</channel_count><nominal_srate>60"
    header += "</nominal_srate><channel_format>float32</channel_format><created_at>1</created_at>"
    header += f"<desc><channels>{channels}</channels></desc></info>"
    samples = [
        b"\x08" + struct.pack("<d", 5 + i / 60) + f.astype("<f4").tobytes()
        for i, f in enumerate(walk(frames))
    ]
    stream = struct.pack("<I", 1)
    parts = [chunk(1, b"<info><version>1.0</version></info>"), chunk(2, stream + header.encode())]
    for i in range(0, frames, 10):
        some = samples[i : i + 10]
        parts.append(chunk(3, stream + varlen(len(some)) + b"".join(some)))
    return b"XDF:" + b"".join(parts)


def osc(frames: int = FRAMES) -> bytes:
    """Return a text log of `oscdump`."""
    lines = []
    for i, frame in enumerate(walk(frames) / [2.56, 1.92, 1.28]):
        stamp = f"eeab8b1e.{i * 2**32 // 60:08x}"
        for joint, (x, y, z) in zip(JOINTS, frame, strict=True):
            lines.append(f'{stamp} /joint sifff "{joint}" 1 {x:.6f} {y:.6f} {z:.6f}\n')
    return "".join(lines).encode()


# File name, content.
WRITERS: dict[str, tuple[str, Callable[..., bytes]]] = {
    "bvh": ("a.bvh", bvh),
    "amc": ("a.amc", amc),
    "npz": ("a.npz", npz),
    "csv": ("a.csv", csv),
    "jsonl": ("a.jsonl", jsonl),
    "msk": ("a.msk", msk),
    "trc": ("a.trc", trc),
    "motive": ("motive.csv", motive),
    "qtm": ("a.tsv", qtm),
    "msrc12": ("msrc.csv", msrc12),
    "ntu": ("a.skeleton", ntu),
    "mediapipe": ("mediapipe.json", mediapipe),
    "openpose": ("openpose.json", openpose),
    "c3d": ("a.c3d", c3d),
    "xdf": ("a.xdf", xdf),
    "osc": ("a.osc", osc),
}
