"""JSON of pose estimators: MediaPipe, TensorFlow.js, OpenPose; one file, or a folder with a file per frame.

A file holds one frame, a list of frames, an object with a list of frames in it, or a frame per line. `pose_frames` has
the known shapes of a frame. Coordinates in metres stay as they are (MediaPipe's world landmarks);
image coordinates have no unit and are scaled so that the skeleton is 1.7 m tall. The y axis of images points
down: they are turned about x so that y points up.
"""

import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from mossar_adapters.files.assembly import sane_frames, scaled_by_height, skeleton_of
from mossar_adapters.files.clock import unit_of_steps
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.options import ReadOptions, plausible_rate
from mossar_adapters.files.pose_frames import PLAIN_TIMES, Pose, PoseError, by_image, frame_list, poses_of
from mossar_adapters.files.pose_lines import PoseLines, has_frame_per_line
from mossar_adapters.files.rates import USUAL_FPS, assumed_rate, nearly_usual, rate_of_times
from mossar_adapters.files.rows import CHUNK
from mossar_adapters.files.running_times import Counting, counting_of
from mossar_adapters.files.text import HEAD_SIZE, encoding_of
from mossar_adapters.files.units import fitted_scale, stated_scale
from mossar_adapters.joint_sets import with_known_parents
from mossar_adapters.maps.json_nan import without_nan
from mossar_adapters.source import Recording
from mossar_stream import Frames

MAX_SIZE = 128 << 20  # bytes of a JSON file, which has to be read as a whole
MAX_PERFORMERS = 16
_MENDED_DEPTH = 2  # frames stand in a list, at most within an object
_BRACKET = re.compile(rb'"(?:[^"\\]++|\\.)*+"?|[][{}]', re.DOTALL)
_CLOSING = bytes.maketrans(b"[{", b"]}")
_NAMES = ("joint_names", "landmark_names", "keypoint_names", "names")
_RATES = ("fps", "frame_rate", "frameRate", "framerate", "ticksPerSecond", "FPS")


class PoseFile(msgspec.Struct):
    """All poses of a recording.

    Args:
        poses: Of each person, by index of the frame.
        times: Seconds of each frame, None where a frame has none.
        fps: Rate that the file states.
        cut: Whether the JSON was cut off.
        names: Of the joints, if the file names them once for all frames.
        plain: Whether the times are in a unit that the file does not name.
    """

    poses: dict[int, dict[int, Pose]]
    times: list[float | None]
    fps: float | None = None
    cut: bool = False
    names: tuple[str, ...] = ()
    plain: bool = False


def read(path: Path, options: ReadOptions) -> Recording:
    """Read poses of one or more people."""
    found = _folder(path, options) if path.is_dir() else _file(path, options)
    if not found.poses:
        raise FileError(path, "there is no pose in it")
    model = max((pose for poses in found.poses.values() for pose in poses.values()), key=_joints)
    performers = {person: f"p{person + 1}" for person in sorted(found.poses)}
    times, fps, notes = _clock(found, options)
    if found.cut:
        notes = (*notes, f"the file is cut off; {len(times)} frames are whole")
    place = {name: i for i, name in enumerate(model.names)}
    fitting = {
        person: sorted(i for i, pose in poses.items() if place.keys() >= set(pose.names))
        for person, poses in found.poses.items()
    }
    count = sum(map(len, fitting.values()))
    if left_out := sum(map(len, found.poses.values())) - count:
        notes = (*notes, f"{left_out} poses with other joints are left out")

    def chunks() -> Iterator[Frames]:
        for person, name in performers.items():
            for start in range(0, len(fitting[person]), CHUNK):
                at = fitting[person][start : start + CHUNK]
                poses = [_spread(found.poses[person][i], model.names, place) for i in at]
                yield _frames(poses, name, times[at])

    parents, root = with_known_parents(model.names)
    skeleton = skeleton_of(path, model.names, parents, root)
    recording = Recording(str(path), skeleton, fps, chunks, notes, count, tuple(performers.values()))
    return scaled_by_height(
        recording, lambda tall: stated_scale(options, 1.0) if model.metric else fitted_scale(options, tall)
    )


def _joints(pose: Pose) -> int:
    return len(pose.names)


def _spread(pose: Pose, names: tuple[str, ...], place: dict[str, int]) -> Pose:
    """Return the pose with all joints, those that it lacks missing."""
    if pose.names == names:
        return pose
    places = [place[name] for name in pose.names]
    positions = np.full((len(names), 3), np.nan)
    positions[places] = pose.positions
    confidence = None
    if pose.confidence is not None:
        confidence = np.zeros(len(names))
        confidence[places] = pose.confidence
    return Pose(names, positions, confidence, pose.metric)


def _frames(poses: list[Pose], name: str, times: np.ndarray[Any, Any]) -> Frames:
    scores = [pose.confidence for pose in poses if pose.confidence is not None]
    confidence = np.stack(scores) if len(scores) == len(poses) else None
    return sane_frames(np.stack([pose.positions for pose in poses]), times, confidence, name)


def _clock(
    found: PoseFile, options: ReadOptions
) -> tuple[np.ndarray[Any, Any], float | None, tuple[str, ...]]:
    count = len(found.times)
    stated = options.fps or found.fps
    times = np.array([np.nan if t is None else t for t in found.times])
    whole = count > 1 and bool(np.isfinite(times).all())
    unit, name = unit_of_steps(times) if whole and found.plain else (1.0, "s")
    times = times * unit
    counted = _counting(found, times) if whole and options.fps is None and found.fps is None else None
    if options.fps is None and whole and counted is None and (np.diff(times) > 0).all():
        notes = () if name == "s" else (f"times taken as {name}",)
        return times, found.fps or rate_of_times(times), notes
    if stated is not None and plausible_rate(stated):
        return np.arange(count) / stated, stated, ()
    if counted is not None:
        return times[0] + np.arange(count) / counted.rate, counted.rate, (counted.note,)
    rate = nearly_usual((rate_of_times(times) if whole else None) or USUAL_FPS)
    return np.arange(count) / rate, rate, (assumed_rate(_why_no_times(times), rate),)


def _counting(found: PoseFile, times: np.ndarray[Any, Any]) -> Counting | None:
    """Return the way to count frames whose times are not those of frames; None if they are."""
    first = min(found.poses)
    nothing = np.full((1, 3), np.nan)
    poses = [
        found.poses[first][i].positions if i in found.poses[first] else nothing for i in range(len(times))
    ]
    return counting_of(times, poses, None)


def _why_no_times(times: np.ndarray[Any, Any]) -> str:
    """Return the reason why the times of frames are not used."""
    missing = int(np.isnan(times).sum())
    if missing == len(times):
        return "the file states neither rate nor times"
    if missing:
        return f"{missing} of {len(times)} frames have no time"
    return "the times do not increase from frame to frame"


def _file(path: Path, options: ReadOptions) -> PoseFile:
    if has_frame_per_line(path):
        return _lines(path, options)
    content, cut = _decoded(path)
    if (about := _recording_of(content)) is not None:
        raise FileError(path, f"this holds no poses; it is about the recording {about}: name that one")
    fps = None
    if isinstance(content, dict):
        fps = next((float(content[key]) for key in _RATES if isinstance(content.get(key), int | float)), None)
    found = PoseFile({}, [], fps if fps is not None and plausible_rate(fps) else None, cut, _names(content))
    for frame in frame_list(content, alone=True):
        _add_frame(path, found, frame, options)
    return found


def _lines(path: Path, options: ReadOptions) -> PoseFile:
    found, lines = PoseFile({}, []), PoseLines(path)
    for people in by_image(lines):
        _add_frame(path, found, people, options)
    found.cut = lines.cut
    return found


def _names(content: Any) -> tuple[str, ...]:
    """Return the names of the joints that stand beside the frames, none if they do not."""
    stated = (
        next((content[key] for key in _NAMES if key in content), None) if isinstance(content, dict) else None
    )
    if isinstance(stated, list) and all(isinstance(name, str) for name in stated):
        return tuple(stated)
    return ()


def _folder(path: Path, options: ReadOptions) -> PoseFile:
    found, labels = PoseFile({}, []), ""
    files = [p for p in path.iterdir() if p.suffix.lower() == ".json" and not p.name.startswith(".")]
    for file in sorted((p for p in files if p.is_file()), key=_frame_order):
        if file.stat().st_size == 0:
            found.times.append(None)  # a frame that was not written
            continue
        content, _ = _decoded(file)
        if (about := _recording_of(content)) is not None:
            labels = (
                f"; {file.name} is about the recording {about}: name that one, or try mossar evaluate {path}"
            )
            continue
        for frame in frame_list(content, alone=False):
            _add_frame(file, found, frame, options)
    if not found.poses:
        raise FileError(path, f"there is no pose in it{labels}")
    return found


def _recording_of(content: Any) -> str | None:
    """Return the recording that labels, or the output of `mossar segment --json`, are about; None for poses."""
    about = content.get("recording") if isinstance(content, dict) else None
    return about[:60] if isinstance(about, str) else None


def _frame_order(path: Path) -> tuple[str, int, str]:
    """Sort 2 before 10: by the last number in the name."""
    numbers = re.findall(r"\d{1,18}", path.stem)
    return re.sub(r"\d+", "", path.stem), int(numbers[-1]) if numbers else 0, path.name


def _add_frame(path: Path, found: PoseFile, frame: Any, options: ReadOptions) -> None:
    index = len(found.times)
    try:
        time, poses = poses_of(frame, allow_2d=options.allow_2d)
    except PoseError as error:
        raise FileError(path, f"frame {index}: {error}") from None
    found.times.append(time)
    found.plain |= isinstance(frame, dict) and any(key in frame for key in PLAIN_TIMES)
    for person, pose in enumerate(poses[:MAX_PERFORMERS]):
        if len(found.names) == len(pose.names):
            pose = msgspec.structs.replace(pose, names=found.names)
        found.poses.setdefault(person, {})[index] = pose


def _decoded(path: Path) -> tuple[Any, bool]:
    """Return the content of a JSON file, and whether it was mended because it was cut off."""
    if path.stat().st_size > MAX_SIZE:
        raise FileError(
            path,
            f"JSON of more than {MAX_SIZE >> 20} MiB cannot be read at once; write a frame per line, or .npz",
        )
    data = path.read_bytes()
    encoding = encoding_of(data[:HEAD_SIZE])
    if encoding is None:
        raise FileError(path, "this is binary data where JSON was expected")
    if encoding != "utf-8":
        data = data.decode(encoding, "replace").lstrip("\ufeff").encode()
    try:
        return msgspec.json.decode(data), False
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        plain = without_nan(data)
        if plain is not None:
            with suppress(msgspec.DecodeError, UnicodeError, RecursionError):
                return msgspec.json.decode(plain), False
        mended = _mended(plain or data)
        if mended is None:
            raise FileError(path, f"this is no JSON: {error}") from None
        return mended, True


def _mended(data: bytes) -> Any:
    """Return the whole part of JSON that was cut off: up to a closed bracket near the end, None if hopeless."""
    still_open = bytearray()
    ends: list[tuple[int, bytes]] = []  # the last places where an element of an outer list or object ends
    for token in _BRACKET.finditer(data):
        bracket = token[0]
        if bracket in b"[{":
            still_open += bracket
        elif bracket in b"]}" and still_open:
            still_open.pop()
            if len(still_open) <= _MENDED_DEPTH:
                ends = [*ends[-3:], (token.end(), bytes(still_open))]
    for end, brackets in reversed(ends):
        try:
            return msgspec.json.decode(data[:end] + brackets[::-1].translate(_CLOSING))
        except (msgspec.DecodeError, UnicodeError, RecursionError):
            continue
    return None
