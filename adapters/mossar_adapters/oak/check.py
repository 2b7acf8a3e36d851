"""The OAK cameras of this computer, and a checklist for their owner."""

import sys
import time
from typing import Final

from mossar_adapters.oak.camera import cameras, description, find_camera, load_sdk, model_folder
from mossar_adapters.oak.separate_process import run_separately
from mossar_adapters.oak.source import OakSource
from mossar_stream import MossarError

PATIENCE: Final = 5.0  # s; loading the SDK and looking around takes one

CHECKLIST: Final = """\
Checklist for owners of a camera (each step takes a minute):
 0. The first run downloads the pose model and says so; the next start without a network, too.
 1. Stand 2 to 4 m away, head to feet in the picture: mossar view oak:   a skeleton of life size follows, head up.
 2. Raise the LEFT arm: left_wrist goes up. Step towards the camera: z grows by as much as you stepped.
 3. mossar run oak: --stats 5   the rate is near 10 Hz (RVC2) or 24 Hz (RVC4), few gaps; lower it with ?fps=.
 4. Stand still for 10 s: no key frames. Then punch, squat, wave with rests between: key frames at the rests.
 5. Two people side by side keep their names p1 and p2; when one leaves, the other's key frames go on.
 6. Unplug the camera for 10 s and plug it in again: "lost", then "is back", and frames go on. Ctrl-C ends it at once.
 7. mossar record oak: take.msk, then mossar run take.msk: the same key frames."""


def check(url: str = "oak:") -> tuple[str, bool]:
    """Return the state of the SDK and of cameras with the checklist for owners, and whether a camera can be used.

    Args:
        url: As for `OakSource.from_url`; may name a camera.

    Raises:
        SettingsError: If an option is unknown or its value impossible.
    """
    wanted = OakSource.from_url(url).options.device
    lines, usable = [], True
    try:
        lines.append(f"depthai {load_sdk().__version__}; models are kept in {model_folder()}")
        lines += [description(info) for info in cameras()]
        find_camera(wanted)
    except MossarError as error:
        lines.append(str(error))
        usable = False
    return "\n".join([*lines, CHECKLIST]), usable


def summary(patience: float = PATIENCE) -> list[str]:
    """Return a few lines: the SDK and the cameras that it sees.

    A process of its own asks, for the SDK may hang on a broken port, and aborts the process that ends meanwhile.

    Args:
        patience: s to wait for it.
    """
    limit = time.monotonic() + patience
    try:
        asked = run_separately(tell, enough=lambda: time.monotonic() > limit)
    except OSError as error:
        return [f"depthai cannot be asked: {error.strerror or error}"]
    if asked is None:
        return [f"depthai has not answered for {patience:g} s; unplug the camera and plug it in again"]
    return asked.stdout.splitlines() or [f"depthai ended without an answer (status {asked.returncode})"]


def tell() -> None:
    """Write the lines of `summary` to standard output."""
    try:
        lines = [f"depthai {load_sdk().__version__}"]
        lines += [description(info) for info in cameras()] or ["no OAK camera found"]
    except MossarError as error:
        lines = [str(error)]
    sys.stdout.write("\n".join(lines) + "\n")
