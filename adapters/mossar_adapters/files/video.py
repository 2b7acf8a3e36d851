"""Videos: the joints of a person in them, estimated once and kept beside the file.

`dance.mp4.pose.npz` is an ordinary archive, which can be read as a recording and copied elsewhere. It is used again as
long as the video is the same; pictures without a person are left out of it.
"""

import logging
import tempfile
from pathlib import Path
from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.extras import needed
from mossar_adapters.files import npz
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.rates import rate_of_times
from mossar_adapters.files.registry import ESTIMATE_SUFFIX
from mossar_adapters.pose.types import SKELETON, PoseError
from mossar_adapters.source import Recording
from mossar_stream import Frames, constant_times

_SHORT: Final = 0.98  # of the pictures that a file states; with fewer it was cut off
_CHUNK: Final = 25  # pictures between two messages of progress

_log = logging.getLogger("mossar.files")
_progress = logging.getLogger("mossar.progress")


class Estimate(msgspec.Struct):
    """The person in a video.

    Args:
        positions: (n, 33, 3) float32, metres.
        times: (n,) s of the video.
        confidence: (n, 33) float32, 0 to 1.
        notes: Notes for the user.
    """

    positions: NDArray[np.float32]
    times: NDArray[np.float64]
    confidence: NDArray[np.float32]
    notes: tuple[str, ...] = ()


def kept_beside(path: Path) -> Path:
    """Return the path of a video's estimate."""
    return path.with_name(path.name + ESTIMATE_SUFFIX)


def read(path: Path, options: ReadOptions) -> Recording:
    """Read a video: the estimate that lies beside it, or a new one."""
    archive = kept_beside(path)
    if not options.again and _is_of(archive, path):
        return msgspec.structs.replace(npz.read(archive, options), path=str(path))
    found = _estimate(path)
    problem = _keep(archive, path, found)
    if not problem:
        notes = (*found.notes, f"the estimate is kept in {archive.name}")
        return msgspec.structs.replace(npz.read(archive, options), path=str(path), notes=notes)
    notes = (*found.notes, f"{archive.name} cannot be written ({problem}): nothing is kept of the estimate")
    return _in_memory(path, found, options, notes)


def _in_memory(path: Path, found: Estimate, options: ReadOptions, notes: tuple[str, ...]) -> Recording:
    """Return an estimate as a recording where the folder of the video cannot be written to."""
    times = found.times if options.fps is None else constant_times(len(found.times), options.fps)
    frames = Frames(found.positions, times, found.confidence)
    fps = options.fps or rate_of_times(times)
    return Recording(str(path), SKELETON, fps, lambda: iter([frames]), notes, len(frames))


def _is_of(archive: Path, path: Path) -> bool:
    """Return whether an archive is the estimate of the present video."""
    try:
        with np.load(archive, allow_pickle=False) as arrays:
            return bool(arrays["video_size"] == path.stat().st_size)
    except (OSError, ValueError, KeyError, EOFError):
        return False


def _estimate(path: Path) -> Estimate:
    """Estimate where the joints of the person in a video are.

    Raises:
        FileError: If it cannot be read as a video, or it has no performer.
        PoseError: If there are no weights.
    """
    needed("ai_edge_litert", "webcam", f"reading {path.name}")
    from mossar_adapters.pose.following import Estimator
    from mossar_adapters.pose.pictures import describe, pictures
    from mossar_adapters.pose.weights import weights

    try:
        video = describe(path)
    except PoseError as error:
        raise FileError(path, str(error).removeprefix(f"{path}: ")) from None
    estimator = Estimator(weights(say=_log.info))
    positions, times, confidence, count = [], [], [], 0
    for picture, time in pictures(path):
        if count % _CHUNK == 0:
            _log_progress(path, count / video.count if video.count else None)
        count += 1
        for body in estimator.estimate(picture, time)[:1]:
            positions.append(body.positions)
            times.append(time)
            confidence.append(body.confidence)
    if not positions:
        what = (
            f"no person was found in its {count} pictures"
            if count
            else "there is no picture in it that can be read"
        )
        raise FileError(path, what)
    notes = [f"a person in {len(times)} of {count} pictures"]
    if count < _SHORT * video.count:
        notes.append(f"the video ends early: {count} of {video.count} pictures can be read")
    return Estimate(np.array(positions), np.array(times), np.array(confidence), tuple(notes))


def _log_progress(path: Path, share: float | None) -> None:
    _progress.debug("estimating poses in %s", path.name, extra={"share": share})


def _keep(archive: Path, path: Path, found: Estimate) -> str:
    """Write an archive; return why it cannot be written, empty if it was."""
    try:
        with tempfile.NamedTemporaryFile(dir=archive.parent, suffix=".npz", delete=False) as file:
            place = Path(file.name)
            try:
                np.savez_compressed(
                    file,
                    positions=found.positions,
                    times=found.times,
                    joint_names=np.array(SKELETON.names),
                    parents=np.array(SKELETON.parents, np.int64),
                    confidence=found.confidence,
                    video_size=np.int64(path.stat().st_size),
                )
            except BaseException:
                place.unlink(missing_ok=True)
                raise
        place.chmod(0o644)
        place.replace(archive)
    except OSError as error:
        return error.strerror or str(error)
    return ""
