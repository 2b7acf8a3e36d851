"""Label Studio: results as predictions that people correct, and the labelling interface that shows them."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.annotations.tiers import AnnotationError, Tier
from mossar_adapters.files.replacing import Draft

TASKS, INTERFACE = ".json", ".xml"
MODEL = "mossar-stream"
_RATE = 30.0  # Hz, of the curve that annotators see


def is_label_studio(path: Path) -> bool:
    """Return whether a file to be written is one of Label Studio."""
    return path.suffix.lower() in {TASKS, INTERFACE}


def write_label_studio(
    path: Path,
    tiers: Sequence[Tier],
    times: NDArray[np.float64],
    positions: NDArray[Any],
    video: str | None = None,
    fps: float | None = None,
    origin: float | None = None,
) -> None:
    """Write a task with predictions (`.json`), or the labelling interface for it (`.xml`).

    Without a video the task is a time series: the mean speed of the joints, which is in the task itself.

    Args:
        path: Which of both by its suffix.
        tiers: The results; each becomes a set of labels.
        times: (n,) s.
        positions: (n, J, 3) m.
        video: Where Label Studio finds the video, whose first frame is that of the recording.
        fps: Of the video, Hz.
        origin: From where times count, s; None: from the first frame.

    Raises:
        AnnotationError: If it cannot be written.
    """
    if path.suffix.lower() == INTERFACE:
        text = _interface(tiers, is_video=video is not None, fps=fps)
    else:
        data: dict[str, Any] = {"ts": _series(times, positions, origin)}
        if video is not None:
            data = {"video": video, "fps": fps}
        results = _results(tiers, None if video is None else fps)
        task = {"data": data, "predictions": [{"model_version": MODEL, "result": results}]}
        text = msgspec.json.format(msgspec.json.encode([task]), indent=1).decode() + "\n"
    try:
        with Draft(path) as draft:
            draft.path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise AnnotationError(f"{path}: cannot be written: {error.strerror or error}") from None


def _results(tiers: Sequence[Tier], fps: float | None) -> list[dict[str, Any]]:
    """Return predictions: s of a time series, or frames from 1 of a video."""
    found: list[dict[str, Any]] = []
    for tier in tiers:
        for mark in tier.marks:
            common = {"id": f"m{len(found)}", "from_name": tier.name.replace(" ", "_")}
            if fps is None:
                times = {"start": mark.start, "end": mark.end, "instant": mark.start == mark.end}
                value = {**times, "timeserieslabels": [mark.label]}
                found.append({**common, "to_name": "ts", "type": "timeserieslabels", "value": value})
                continue
            span = {"start": round(mark.start * fps) + 1, "end": round(mark.end * fps) + 1}
            value = {"ranges": [span], "timelinelabels": [mark.label]}
            found.append({**common, "to_name": "video", "type": "timelinelabels", "value": value})
    return found


def _interface(tiers: Sequence[Tier], *, is_video: bool, fps: float | None) -> str:
    kind, target = ("TimelineLabels", "video") if is_video else ("TimeSeriesLabels", "ts")
    lines = ["<View>"]
    for tier in tiers:
        lines.append(f'  <{kind} name={quoteattr(tier.name.replace(" ", "_"))} toName="{target}">')
        lines += [
            f"    <Label value={quoteattr(label)}/>" for label in dict.fromkeys(m.label for m in tier.marks)
        ]
        lines.append(f"  </{kind}>")
    if is_video:
        lines.append(f'  <Video name="video" value="$video" frameRate="{fps or 25:g}"/>')
    else:
        lines.append('  <TimeSeries name="ts" valueType="json" value="$ts" timeColumn="time">')
        lines.append('    <Channel column="speed" displayName="mean speed of the joints, m/s"/>')
        lines.append("  </TimeSeries>")
    return "\n".join([*lines, "</View>", ""])


def _series(
    times: NDArray[np.float64], positions: NDArray[Any], origin: float | None
) -> dict[str, list[float]]:
    """Return the mean speed of the joints at some 30 Hz, over the time from the origin."""
    moments = times - (times[0] if origin is None else origin) if len(times) else times
    length = float(np.ptp(moments)) if len(moments) else 0.0
    step = max(1, int(len(moments) / max(1.0, length * _RATE)))
    moments, poses = moments[::step], np.nan_to_num(np.asarray(positions[::step], np.float64))
    if len(moments) < 2:
        return {"time": moments.tolist(), "speed": [0.0] * len(moments)}
    speeds = np.linalg.norm(np.diff(poses, axis=0), axis=2).mean(axis=1) / np.maximum(np.diff(moments), 1e-9)
    return {"time": moments.round(4).tolist(), "speed": [0.0, *speeds.round(4).tolist()]}
