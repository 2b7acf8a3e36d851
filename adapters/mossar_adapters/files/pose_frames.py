"""Shapes in which pose estimators write a frame.

A frame is an object with one of the keys below, or a bare pose. A pose is a list of points: objects with x, y
and z (and `name`, `score`, `visibility`, `confidence`), or lists `[x, y, z]` or `[x, y, z, confidence]`; or
OpenPose's flat list of x, y, z, confidence.
"""

from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.joint_sets import by_count
from mossar_stream.errors import MossarError
from mossar_stream.skeleton import MAX_JOINTS

_FRAME_LISTS = ("frames", "data", "poses", "results", "sequence", "pose_frames", "annotations")
_TIMES = {"time": 1.0, "t": 1.0, "timestamp": 1.0, "timestamp_s": 1.0, "time_s": 1.0, "timestamp_ms": 1e-3}
_TIMES |= {"timestampMs": 1e-3, "time_ms": 1e-3, "timestamp_us": 1e-6}
_METRIC: tuple[str, ...] = (
    "pose_world_landmarks",
    "poseWorldLandmarks",
    "world_landmarks",
    "worldLandmarks",
    "keypoints3D",
)
_METRIC += ("keypoints_3d", "joints3d", "joints_3d")
_IMAGE = ("pose_landmarks", "poseLandmarks", "landmarks", "keypoints", "pose", "joints", "landmark")
_PEOPLE = ("people", "persons", "poses", "bodies", "instances")
_SCORES = ("visibility", "score", "confidence", "presence", "c")
_DEEPEST = 6  # nested lists and objects until a pose must come


class PoseError(MossarError):
    """A frame cannot be used; the reader adds the file and the number of the frame."""


class Pose(msgspec.Struct, frozen=True):
    """One person in one frame.

    Args:
        names: Of the joints.
        positions: (J, 3), y up.
        confidence: (J,) or None.
        metric: Whether the coordinates are in metres.
    """

    names: tuple[str, ...]
    positions: NDArray[np.float64]
    confidence: NDArray[np.float64] | None
    metric: bool


def frame_list(content: Any) -> list[Any]:
    """Return the frames in a file; a file that is no list of frames is one."""
    for _ in range(3):
        if isinstance(content, list):
            return [content] if _is_pose(content) else content
        if not isinstance(content, dict) or any(key in content for key in (*_METRIC, *_IMAGE, "people")):
            break
        inner = next(
            (content[key] for key in _FRAME_LISTS if isinstance(content.get(key), list | dict)), None
        )
        if inner is None and content and all(str(key).isdecimal() for key in content):
            inner = [content[key] for key in sorted(content, key=lambda key: int(key[:18]))]
        if inner is None:
            break
        content = inner
    return [content]


def poses_of(frame: Any, *, allow_2d: bool) -> tuple[float | None, list[Pose]]:
    """Return the time of a frame, None if it has none, and its poses, none if nobody is in it.

    Raises:
        PoseError: If it is 2-D and that is not allowed, or no pose can be found in it.
    """
    time = None
    if isinstance(frame, dict):
        for key, unit in _TIMES.items():
            if isinstance(frame.get(key), int | float) and abs(frame[key]) < 1e18:
                time = float(frame[key]) * unit
                break
    return time, [
        pose for pose in _poses(frame, metric=False, depth=0, allow_2d=allow_2d) if pose is not None
    ]


def _poses(found: Any, *, metric: bool, depth: int, allow_2d: bool) -> list[Pose | None]:
    if depth > _DEEPEST:
        raise PoseError("no pose is found in it")
    if not found:
        return []
    if _is_pose(found):
        return [_pose(found, metric=metric, allow_2d=allow_2d)]
    if isinstance(found, list):
        people = [_poses(one, metric=metric, depth=depth + 1, allow_2d=allow_2d) for one in found]
        return [pose for poses in people for pose in poses]
    if not isinstance(found, dict):
        raise PoseError("no pose is found in it")
    if "pose_keypoints_3d" in found or "pose_keypoints_2d" in found:
        return [_openpose(found, allow_2d=allow_2d)]
    for key in (*_METRIC, *_PEOPLE, *_IMAGE):
        if key in found:
            deeper = metric or key in _METRIC
            return _poses(found[key], metric=deeper, depth=depth + 1, allow_2d=allow_2d)
    raise PoseError(f"no pose is found in it (keys: {', '.join(str(key)[:20] for key in list(found)[:8])})")


def _is_pose(found: Any) -> bool:
    """Return whether this is a list of points."""
    if not isinstance(found, list) or not found:
        return False
    first = found[0]
    if isinstance(first, dict):
        return "x" in first and "y" in first
    return isinstance(first, list) and 2 <= len(first) <= 4 and all(_is_number(value) for value in first)


def _is_number(value: Any) -> bool:
    return value is None or (isinstance(value, int | float) and not isinstance(value, bool))


def _pose(points: list[Any], *, metric: bool, allow_2d: bool) -> Pose:
    if len(points) > MAX_JOINTS:
        raise PoseError(f"a pose has {len(points)} points; at most {MAX_JOINTS} can be used")
    rows = [_point(point) for point in points]
    values = np.array([[np.nan if v is None else _float(v) for v in row[:4]] for row in rows])
    flat = all(row[2] is None for row in rows)
    _check_flat(flat=flat, allow_2d=allow_2d)
    if flat:
        values[:, 2] = np.where(np.isfinite(values[:, 0]), 0.0, np.nan)
    names = tuple(str(p["name"]) if isinstance(p, dict) and p.get("name") else "" for p in points)
    if not all(names):
        names = _names(len(points))
    confidence = values[:, 3] if np.isfinite(values[:, 3]).all() else None
    return Pose(names, values[:, :3] * (1.0, -1.0, -1.0), confidence, metric and not flat)


def _point(point: Any) -> list[Any]:
    """Return x, y, z and confidence, None where there is none."""
    if isinstance(point, dict):
        score = next((point[key] for key in _SCORES if point.get(key) is not None), None)
        values = [point.get("x"), point.get("y"), point.get("z"), score]
    elif isinstance(point, list):
        values = (point + [None] * 4)[:4]
    else:
        values = [None] * 4
    if not all(_is_number(value) for value in values):
        raise PoseError("a coordinate is not a number")
    return values


def _float(value: float) -> float:
    return float(value) if abs(value) < 1e30 else float("nan")


def _names(count: int) -> tuple[str, ...]:
    known = by_count(count)
    return known.names if known else tuple(f"joint{i}" for i in range(count))


def _check_flat(*, flat: bool, allow_2d: bool) -> None:
    if flat and not allow_2d:
        raise PoseError(
            "its poses are 2-D, which hides motion towards the camera; --allow-2d takes them anyway"
        )


def _openpose(person: dict[str, Any], *, allow_2d: bool) -> Pose | None:
    """Return OpenPose's flat list as a pose; points with confidence 0 are missing."""
    width, values = 4, person.get("pose_keypoints_3d")
    if not values:
        width, values = 3, person.get("pose_keypoints_2d")
    if not values:
        return None
    _check_flat(flat=width == 3, allow_2d=allow_2d)
    if not isinstance(values, list):
        raise PoseError("the keypoints of a person are no list")
    if len(values) % width or len(values) > width * MAX_JOINTS:
        raise PoseError(f"a person has {len(values)} numbers, which are not {width} for each joint")
    if not all(_is_number(value) for value in values):
        raise PoseError("a coordinate is not a number")
    table = np.array([np.nan if v is None else _float(v) for v in values]).reshape(-1, width)
    points = np.zeros((len(table), 3))
    points[:, : width - 1] = table[:, :-1]
    points[~(table[:, -1] > 0)] = np.nan
    return Pose(_names(len(table)), points * (1.0, -1.0, -1.0), np.nan_to_num(table[:, -1]), metric=False)
