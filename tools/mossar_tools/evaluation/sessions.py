"""Sessions: recordings of moves on command, and the examples that their players showed.

A folder of sessions holds, beside each recording, one JSON object::

    {"recording": "ann.npz", "commands": [[0, 165, "jab_left"], [165, 300, "duck"]]}

A command has a first frame, an end that does not belong to it, and a move that the player did between them. If the next
command has the same move, the first try was bad and does not count. The examples are in a file of `mossar teach` that
`moves` names, or in `samples/ann.npz` beside the folder of the label file: arrays (n, J, 3), metres, called MOVE_NUMBER,
with `fps` if it is not that of the session.
"""

import re
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files import FileError, ReadOptions, open_recording
from mossar_adapters.files.loaded import load
from mossar_adapters.regular import check_regular
from mossar_stream import Moves, Skeleton
from mossar_tools.evaluation.labels import MAX_BYTES, LabelError
from mossar_tools.moves_file import read_moves

SAMPLES = "samples"  # folder of examples
USUAL_FPS = 30.0
_NUMBERED = re.compile(r"(.+)_(\d+)")

Poses = NDArray[np.float32]
Shown = dict[str, list[Poses]]  # (n, J, 3) m, the examples of each move


class Session(msgspec.Struct, frozen=True):
    """One recording of moves on command.

    Args:
        name: For the tables.
        skeleton: The joints.
        fps: Rate, Hz.
        positions: (n, J, 3) m.
        times: (n,) s.
        commands: First frame, end, and move.
        examples: Examples that the player showed.
    """

    name: str
    skeleton: Skeleton
    fps: float
    positions: Poses
    times: NDArray[np.float64]
    commands: list[tuple[int, int, str]]
    examples: "Examples"


class Examples(msgspec.Struct, frozen=True):
    """The examples of one player.

    Args:
        shown: Examples by move.
        fps: Rate of each example by move, Hz.
        skeleton: The joints.
    """

    shown: Shown
    fps: Mapping[str, list[float]]
    skeleton: Skeleton

    def moves(self, chosen: slice) -> Moves:
        """Return moves taught with some of the examples.

        Args:
            chosen: Slice of the examples of each move.
        """
        moves = Moves(self.skeleton)
        for name, examples in self.shown.items():
            for positions, fps in list(zip(examples, self.fps[name], strict=True))[chosen]:
                moves.add(name, positions, fps)
        return moves

    @property
    def most(self) -> int:
        """Number of examples of the move with the most examples."""
        return max(map(len, self.shown.values()), default=0)


class _Label(msgspec.Struct, frozen=True):
    recording: str
    commands: list[tuple[int, int, str]]
    fps: float | None = None
    moves: str | None = None
    unit: str = "auto"


def session_labels(folder: Path) -> list[Path]:
    """Return the label files of sessions in a folder and the folders in it."""
    return [path for path in sorted(folder.rglob("*.json")) if _has_commands(path)] if folder.is_dir() else []


def sample_files(folder: Path) -> list[Path]:
    """Return the archives of examples in a folder, or in the folder `samples` in it."""
    for place in (folder / SAMPLES, folder):
        found = [path for path in sorted(place.glob("*.npz")) if _holds_examples(path)]
        if found:
            return found
    return []


def load_session(path: Path) -> Session:
    """Return the session that a label file describes.

    Raises:
        MossarError: If the label file, its recording or the examples cannot be used.
    """
    label = _read_label(path)
    recording = open_recording(path.parent / label.recording, ReadOptions(fps=label.fps, unit=label.unit))
    loaded = load(recording)
    positions, times = loaded.positions, loaded.times
    if len(times) < 2:
        raise FileError(recording.path, "fewer than two frames")
    fps = recording.fps or (len(times) - 1) / float(times[-1] - times[0])
    for begin, end, move in label.commands:
        if not 0 <= begin < end <= len(times):
            raise LabelError(f"{path}: {move} from frame {begin} to {end}; there are {len(times)} frames")
    return Session(
        path.stem,
        loaded.skeleton,
        fps,
        positions,
        times,
        label.commands,
        _examples_for(path, label, loaded.skeleton, fps),
    )


def load_examples(path: Path, skeleton: Skeleton | None = None, fps: float = USUAL_FPS) -> Examples:
    """Return the examples of an archive.

    Args:
        path: With arrays (n, J, 3) called MOVE_NUMBER, and `joint_names`, `parents`, `fps` if they are known.
        skeleton: For an archive without joints; None for joints without names, all children of the first.
        fps: For an archive without a rate, Hz.

    Raises:
        LabelError: If it cannot be read.
    """
    shown: Shown = {}
    try:
        with np.load(path, allow_pickle=False) as archive:
            own = {name: archive[name] for name in archive.files}
    except (OSError, ValueError, zipfile.BadZipFile, EOFError) as error:
        raise LabelError(f"{path}: cannot be read: {error}") from None
    for name, array in own.items():
        found = _NUMBERED.fullmatch(name)
        if found and array.ndim == 3:
            shown.setdefault(found[1], []).append(array)
    if not shown:
        raise LabelError(f"{path}: no examples; they are arrays (n, J, 3) called MOVE_NUMBER")
    rate = float(own.get("fps", fps))
    joints = next(iter(shown.values()))[0].shape[1]
    named = _skeleton_of(own) or skeleton
    if named is None or len(named) != joints:
        named = Skeleton(tuple(f"joint{i}" for i in range(joints)), (-1, *[0] * (joints - 1)))
    return Examples(shown, {name: [rate] * len(parts) for name, parts in shown.items()}, named)


def _skeleton_of(own: Mapping[str, NDArray[np.generic]]) -> Skeleton | None:
    if "joint_names" not in own or "parents" not in own:
        return None
    return Skeleton(tuple(map(str, own["joint_names"])), tuple(int(i) for i in own["parents"].tolist()))


def _examples_for(path: Path, label: _Label, skeleton: Skeleton, fps: float) -> Examples:
    if label.moves is not None:
        moves = read_moves(path.parent / label.moves)
        shown: Shown = {}
        rates: dict[str, list[float]] = {}
        for example in moves.examples:
            shown.setdefault(example.name, []).append(example.metres(len(moves.skeleton)))
            rates.setdefault(example.name, []).append(example.fps)
        return Examples(shown, rates, moves.skeleton)
    for place in (path.parent / SAMPLES, path.parent.parent / SAMPLES):
        if (place / f"{path.stem}.npz").exists():
            return load_examples(place / f"{path.stem}.npz", skeleton, fps)
    raise LabelError(
        f'{path}: no examples; name a file of mossar teach as "moves", or put them into {SAMPLES}/'
    )


def _has_commands(path: Path) -> bool:
    try:
        check_regular(path)
        if path.stat().st_size > MAX_BYTES:
            return False
        content = msgspec.json.decode(path.read_bytes())
    except (OSError, msgspec.DecodeError, RecursionError):
        return False
    return isinstance(content, dict) and "recording" in content and "commands" in content


def _read_label(path: Path) -> _Label:
    try:
        return msgspec.json.decode(path.read_bytes(), type=_Label)
    except OSError as error:
        raise LabelError(f"{path}: cannot be read: {error.strerror or error}") from None
    except msgspec.DecodeError as error:
        raise LabelError(f"{path}: {error}") from None


def _holds_examples(path: Path) -> bool:
    try:
        with zipfile.ZipFile(path) as archive:
            names = [name.removesuffix(".npy") for name in archive.namelist()]
    except (OSError, zipfile.BadZipFile):
        return False
    return bool(names) and "positions" not in names and any(map(_NUMBERED.fullmatch, names))


def load_sessions(folder: Path, on_progress: Callable[[str], None]) -> list[Session]:
    """Return the sessions of a folder; see `load_session`.

    Args:
        folder: The folder.
        on_progress: Gets the name of each label file before its recording is read.
    """
    found = []
    for path in session_labels(folder):
        on_progress(str(path))
        found.append(load_session(path))
    return found
