"""Shapes in which pose estimators write a frame.

A frame is an object with one of the keys below, or a bare pose. A pose is a list of points: objects with x, y
and z (and `name`, `score`, `visibility`, `confidence`), or lists `[x, y, z]` or `[x, y, z, confidence]`; an
object with a point for each joint's name; or a flat list: OpenPose's and COCO's with confidences, or x, y, z
(and confidence) of as many joints as one of the known sets has.
"""

import re
from collections.abc import Iterable, Iterator
from itertools import groupby
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.joint_sets import by_count
from mossar_stream import MAX_JOINTS, MossarError

_FRAME_LISTS = (
    "frames",
    "data",
    "poses",
    "results",
    "sequence",
    "pose_frames",
    "annotations",
    "positions",
)
_FRAME_NAME = re.compile(r"(?:frame|image|img|f)?[\s_.:-]*(\d{1,18})(?:\.\w{1,5})?", re.IGNORECASE)
_COCO = {3 * joints for joints in (17, 18, 25, 26, 133, 136)}
# How many numbers x, y, score make a flat pose: COCO's, and OpenPose's of 2017.
_FLAT_2D = {"keypoints": _COCO, "pose_keypoints": _COCO | {45}, "joints": {54}}
_FEWEST = 3  # named points that make a pose; a box or a size has fewer
PLAIN_TIMES = ("time", "t", "timestamp")  # which may be in any unit
_TIMES = {"time": 1.0, "t": 1.0, "timestamp": 1.0, "timestamp_s": 1.0, "time_s": 1.0, "timestamp_ms": 1e-3}
_TIMES |= {"timestampMs": 1e-3, "time_ms": 1e-3, "timestamp_us": 1e-6, "timestamp_usec": 1e-6}
_METRIC: tuple[str, ...] = (
    "pose_world_landmarks",
    "poseWorldLandmarks",
    "world_landmarks",
    "worldLandmarks",
    "keypoints3D",
)
_METRIC += ("keypoints_3d", "joints3d", "joints_3d")
_IMAGE = (
    "pose_landmarks",
    "poseLandmarks",
    "landmarks",
    "keypoints",
    "pose",
    "joints",
    "landmark",
    "joint_positions",
)
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


def frame_list(content: Any, *, alone: bool) -> list[Any]:
    """Return the frames in a file; a file that is no list of frames is one.

    Args:
        content: Of the file.
        alone: Whether the file is the whole recording: then poses in a list are frames, else people.
    """
    for _ in range(3):
        if isinstance(content, list):
            return [content] if _is_pose(content) else list(by_image(content))
        if not isinstance(content, dict):
            break
        known = [content[key] for key in (*_METRIC, *_IMAGE) if key in content]
        if alone and known and _are_poses(known[0]) and not any(key in content for key in _TIMES):
            return list(known[0])
        if known or "people" in content:
            break
        inner = next(
            (content[key] for key in _FRAME_LISTS if isinstance(content.get(key), list | dict)), None
        )
        inner = _by_number(content) if inner is None else inner
        if inner is None:
            break
        content = inner
    return [content]


def _are_poses(found: Any) -> bool:
    return isinstance(found, list) and len(found) > 1 and all(_is_pose(one) for one in found)


def _by_number(content: dict[str, Any]) -> list[Any] | None:
    """Return the values of `0`, `1` … or `frame_0`, `frame_1` … in their order, None if there are other keys."""
    numbers = [_FRAME_NAME.fullmatch(key) for key in content]
    if not content or None in numbers or any(_is_point(value) for value in content.values()):
        return None
    keys = sorted(content, key=lambda key: int(re.findall(r"\d{1,18}", key)[0]))
    return [content[key] for key in keys]


def by_image(frames: Iterable[Any]) -> Iterator[Any]:
    """Yield the frames; consecutive people of the same image as a list."""
    for _, people in groupby(frames, key=_image):
        found = list(people)
        yield found[0] if len(found) == 1 else found


def _image(frame: Any) -> Any:
    """Return the id of the image of a frame."""
    return frame["image_id"] if isinstance(frame, dict) and "image_id" in frame else object()


def may_hold_poses(frame: dict[str, Any]) -> bool:
    """Return whether an object has a key under which poses stand, so that an error message about them is useful."""
    keys = (*_METRIC, *_PEOPLE, *_IMAGE, *_FLAT_2D, "people", "pose_keypoints_3d", "pose_keypoints_2d")
    return any(key in frame for key in keys) or sum(map(_is_point, frame.values())) >= _FEWEST


def poses_of(frame: Any, *, allow_2d: bool) -> tuple[float | None, list[Pose]]:
    """Return the time of a frame, None if it has none, and its poses, an empty list if there is no person in it.

    Raises:
        PoseError: If it is 2-D and that is not allowed, or no pose can be found in it.
    """
    time = None
    if isinstance(frame, dict):
        for key, unit in _TIMES.items():
            if isinstance(frame.get(key), int | float) and abs(frame[key]) < 1e19:
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
    if width := _flat_width(found):
        rows = [found[i : i + width] for i in range(0, len(found), width)]
        return [_pose(rows, metric=metric, allow_2d=allow_2d)]
    if isinstance(found, list):
        people = [_poses(one, metric=metric, depth=depth + 1, allow_2d=allow_2d) for one in found]
        return [pose for poses in people for pose in poses]
    if not isinstance(found, dict):
        raise PoseError("no pose is found in it")
    if "pose_keypoints_3d" in found or "pose_keypoints_2d" in found:
        return [_openpose(found, allow_2d=allow_2d)]
    for key, sizes in _FLAT_2D.items():
        if _is_numbers(found.get(key)) and len(found[key]) in sizes and _are_scores(found[key][2::3]):
            return [_openpose({"pose_keypoints_2d": found[key]}, allow_2d=allow_2d)]
    for key in (*_METRIC, *_PEOPLE, *_IMAGE):
        if key in found:
            deeper = metric or key in _METRIC
            return _poses(found[key], metric=deeper, depth=depth + 1, allow_2d=allow_2d)
    named = {name: point for name, point in found.items() if _is_point(point)}
    if len(named) >= _FEWEST:
        return [_pose(list(named.values()), metric=metric, allow_2d=allow_2d, names=tuple(named))]
    if {"examples", "rules"} <= found.keys():
        raise PoseError("this is a file of moves, for --moves")
    raise PoseError(f"no pose is found in it (keys: {', '.join(str(key)[:20] for key in list(found)[:8])})")


def _is_pose(found: Any) -> bool:
    """Return whether this is a list of points."""
    return isinstance(found, list) and bool(found) and _is_point(found[0])


def _is_point(found: Any) -> bool:
    if isinstance(found, dict):
        return "x" in found and "y" in found
    return isinstance(found, list) and 2 <= len(found) <= 4 and all(_is_number(value) for value in found)


def _is_numbers(found: Any) -> bool:
    return isinstance(found, list) and len(found) > 4 and all(_is_number(value) for value in found)


def _flat_width(found: Any) -> int:
    """Return the number of values per joint in a flat list, 0 if it fits no known set."""
    if not _is_numbers(found):
        return 0
    fitting = [w for w in (4, 3) if len(found) % w == 0 and by_count(len(found) // w)]
    return next((w for w in fitting if w == 3 or _are_scores(found[3::4])), 0)


def _are_scores(values: list[Any]) -> bool:
    """Return whether these may be confidences, or COCO's 0, 1 and 2, rather than coordinates."""
    return all(value is None or 0 <= value <= 2 for value in values)


def _is_number(value: Any) -> bool:
    return value is None or (isinstance(value, int | float) and not isinstance(value, bool))


def _pose(points: list[Any], *, metric: bool, allow_2d: bool, names: tuple[str, ...] = ()) -> Pose:
    if len(points) > MAX_JOINTS:
        raise PoseError(f"a pose has {len(points)} points; at most {MAX_JOINTS} can be used")
    rows = [_point(point) for point in points]
    values = np.array([[np.nan if v is None else _float(v) for v in row[:4]] for row in rows])
    flat = all(row[2] is None for row in rows) and any(None not in row[:2] for row in rows)
    _check_flat(flat=flat, allow_2d=allow_2d)
    if flat:
        values[:, 2] = np.where(np.isfinite(values[:, 0]), 0.0, np.nan)
    names = names or tuple(str(p["name"]) if isinstance(p, dict) and p.get("name") else "" for p in points)
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
