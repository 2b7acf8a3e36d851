"""The readers of file formats: one table.

A new format is one module with `read(path, options) -> Recording` and one row here.
"""

import contextlib
import difflib
import importlib
import importlib.util
import itertools
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, Final

import msgspec

from mossar_adapters.address import readable
from mossar_adapters.extras import install_line
from mossar_adapters.files import sniff
from mossar_adapters.files.body import checked
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.kinematics import JointMotion
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.running_times import with_running_times
from mossar_adapters.files.selection import selected
from mossar_adapters.files.text import HEAD_SIZE
from mossar_adapters.joint_sets import printable_names
from mossar_adapters.source import Recording
from mossar_stream import Frames


class Format(msgspec.Struct, frozen=True):
    """One file format.

    Args:
        name: For the user.
        extensions: Lower case with the dot; compared with the end of the file's name.
        sniff: Whether a file whose first 64 KiB these are is of this format, asked after the extension; gets
            the bytes and the path.
        module: Module that holds `read(path, options) -> Recording`, imported when it is needed.
        description: One line for `mossar adapters`.
        extra: Extra of the distribution that brings the library, None if none is needed.
        library: Module whose absence means that the extra is missing.
        folder: Whether it reads folders too.
        motion: Whether the module also has `read_motion(path, options) -> JointMotion`.
        decisive: Whether the sniffer alone decides, whatever the extension.
        timed: Whether a file has a time for each frame, by a clock that may not have run.
        plain: Whether those times may be in another unit than seconds, without a word about it.
    """

    name: str
    extensions: tuple[str, ...]
    sniff: Callable[[bytes, Path], bool]
    module: str
    description: str
    extra: str | None = None
    library: str | None = None
    folder: bool = False
    motion: bool = False
    decisive: bool = False
    timed: bool = False
    plain: bool = False

    def available(self) -> bool:
        """Return whether its extra is installed."""
        return self.library is None or importlib.util.find_spec(self.library) is not None


_MOST_LISTED = 1000  # files of a folder among which a similar name is searched
_HERE = "mossar_adapters.files"

VIDEO_SUFFIXES: Final = (".mp4", ".mov", ".avi", ".webm", ".mkv")
ESTIMATE_SUFFIX: Final = ".pose.npz"  # of the estimate kept beside a video
FORMATS: tuple[Format, ...] = (
    Format(
        "BVH",
        (".bvh",),
        sniff.text(sniff.bvh),
        f"{_HERE}.bvh",
        "skeleton and joint rotations",
        motion=True,
        decisive=True,
    ),
    Format(
        "AMC", (".amc",), sniff.text(sniff.amc), f"{_HERE}.amc", "rotations for an .asf skeleton", motion=True
    ),
    Format(
        "npz",
        (".npz",),
        sniff.magic(b"PK"),
        f"{_HERE}.npz",
        "numpy archive of positions",
        timed=True,
        plain=True,
    ),
    Format(
        "TRC", (".trc",), sniff.text(sniff.trc), f"{_HERE}.trc", "markers in text", decisive=True, timed=True
    ),
    Format(
        "Motive CSV",
        (".csv",),
        sniff.text(sniff.motive),
        f"{_HERE}.motive",
        "OptiTrack skeletons or markers",
        decisive=True,
        timed=True,
    ),
    Format(
        "QTM",
        (".tsv", ".txt"),
        sniff.text(sniff.qtm),
        f"{_HERE}.qtm",
        "Qualisys markers",
        decisive=True,
        timed=True,
    ),
    Format(
        "MSRC-12",
        (".csv", ".txt"),
        sniff.text(sniff.msrc12),
        f"{_HERE}.msrc12",
        "Kinect gestures",
        timed=True,
    ),
    Format("NTU", (".skeleton",), sniff.text(sniff.ntu), f"{_HERE}.ntu", "NTU RGB+D Kinect bodies"),
    Format("msk", (".msk",), sniff.msk, f"{_HERE}.msk", "our own recordings", decisive=True, timed=True),
    Format(
        "XDF",
        (".xdf",),
        sniff.magic(b"XDF:"),
        f"{_HERE}.xdf",
        "motion capture stream of Lab Streaming Layer",
        extra="files",
        library="pyxdf",
        decisive=True,
        timed=True,
    ),
    Format("C3D", (".c3d",), sniff.c3d, f"{_HERE}.c3d", "markers of optical systems"),
    Format(
        "JSON lines",
        (".jsonl", ".ndjson", ".json"),
        sniff.text(sniff.json_lines),
        f"{_HERE}.jsonl",
        "frames as JSON",
        timed=True,
        plain=True,
    ),
    Format(
        "pose JSON",
        (".json", ".jsonl", ".ndjson"),
        sniff.pose_json,
        f"{_HERE}.pose_json",
        "MediaPipe, OpenPose; a file, or a folder with a file per frame",
        folder=True,
    ),
    Format(
        "OSC log",
        (".osc", ".oscdump", ".log", ".txt"),
        sniff.text(sniff.osc_log),
        f"{_HERE}.osc_log",
        "messages that oscdump wrote down",
    ),
    Format(
        "video",
        VIDEO_SUFFIXES,
        sniff.video,
        f"{_HERE}.video",
        "a person in pictures; estimated once, kept beside the file",
        extra="webcam",
        library="ai_edge_litert",
    ),
    Format(
        "CSV",
        (".csv", ".tsv", ".txt"),
        sniff.text(sniff.any_text),
        f"{_HERE}.table",
        "table of joint positions",
        timed=True,
    ),
)


def open_recording(
    path: Path | str, options: ReadOptions | None = None, formats: Sequence[Format] = FORMATS
) -> Recording:
    """Open a recording with the reader for its format.

    Args:
        path: File, or folder of per-frame files.
        options: The user's options for it.
        formats: The table to look in.

    Returns:
        The recording, with only the selected joints and performer.

    Raises:
        FileError: If it cannot be read; one line has the reason.
    """
    options = options or ReadOptions()
    path = Path(path)
    form = format_of(path, formats)
    read: Callable[[Path, ReadOptions], Recording] = _reader(form, path, "read")
    with _clear_errors(path):
        recording = selected(checked(read(path, options), options), options)
        if form.timed:
            recording = with_running_times(recording, options, plain=form.plain)

    def chunks() -> Iterator[Frames]:
        with _clear_errors(path):
            yield from recording.chunks()

    return msgspec.structs.replace(
        recording,
        path=readable(recording.path),
        skeleton=printable_names(recording.skeleton),
        chunks=chunks,
    )


def open_motion(
    path: Path | str, options: ReadOptions | None = None, formats: Sequence[Format] = FORMATS
) -> JointMotion:
    """Open the joint rotations of a recording.

    Raises:
        FileError: If it cannot be read or has positions only.
    """
    path = Path(path)
    form = format_of(path, formats)
    if not form.motion:
        raise FileError(path, f"{form.name} has joint positions but no rotations")
    with _clear_errors(path):
        motion: JointMotion = _reader(form, path, "read_motion")(path, options or ReadOptions())
    return motion


def format_of(path: Path, formats: Sequence[Format] = FORMATS) -> Format:
    """Return the format of a file: the first that knows its content.

    Decisive formats come first, whatever the extension; then those with its extension.

    Raises:
        FileError: If there is no such file or no such format.
    """
    head = _head(path)
    if path.is_dir():
        decisive, candidates = [], [form for form in formats if form.folder]
    else:
        decisive = [form for form in formats if form.decisive]
        candidates = [form for form in formats if path.name.lower().endswith(form.extensions)]
    with _clear_errors(path):
        for form in (*decisive, *candidates):
            if form.sniff(head, path):
                return form
    if path.is_dir():
        raise FileError(
            path, "this is a folder without recordings of single frames (.json); name the recordings in it"
        )
    for beginning, advice in sniff.PACKED.items():
        if head.startswith(beginning):
            raise FileError(path, f"this is {advice}")
    if candidates:
        raise FileError(path, f"this does not look like {' or '.join(form.name for form in candidates)}")
    if path.suffix.lower() == ".asf":
        raise FileError(path, "this is a skeleton without motion; open the .amc that goes with it")
    known = sorted({extension for form in formats for extension in form.extensions})
    raise FileError(path, f"the extension {path.suffix!r} is not known; known are {' '.join(known)}")


@contextlib.contextmanager
def _clear_errors(path: Path) -> Iterator[None]:
    """Turn an error of the system into one line; it may be about another file, such as one in a folder."""
    try:
        yield
    except OSError as error:
        raise FileError(error.filename or path, f"cannot be read: {error.strerror or error}") from None


def _similar(path: Path) -> str:
    """Return a question that names a file of the folder, if the path has a name like it and is not there."""
    if any(sign in path.name for sign in "*?"):
        return "; no file fits this pattern"
    with contextlib.suppress(OSError):
        if not path.exists() and path.parent.is_dir():
            names = [entry.name for entry in itertools.islice(path.parent.iterdir(), _MOST_LISTED)]
            near = difflib.get_close_matches(path.name, names, 1)
            return f" - did you mean {path.with_name(near[0])}?" if near else ""
    return ""


def _head(path: Path) -> bytes:
    try:
        if path.is_dir():
            return b""
        if path.exists() and not path.is_file():
            raise FileError(path, "this is no file but a pipe or a device; mossar run - reads JSON lines")
        with path.open("rb") as file:
            head = file.read(HEAD_SIZE)
    except OSError as error:
        raise FileError(path, f"cannot be opened: {error.strerror or error}{_similar(path)}") from None
    except ValueError as error:
        raise FileError(path, f"cannot be opened: {error}") from None
    if not head:
        raise FileError(path, "the file is empty")
    return head


def _reader(form: Format, path: Path, function: str) -> Callable[..., Any]:
    if not form.available():
        raise FileError(path, f"reading {form.name} needs an extra: {install_line(form.extra or '')}")
    reader: Callable[..., Any] = getattr(importlib.import_module(form.module), function)
    return reader
