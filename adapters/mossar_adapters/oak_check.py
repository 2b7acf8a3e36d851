"""What there is of OAK cameras here, and how their owner can see that everything works."""

from typing import Final

from mossar_adapters.oak_camera import cameras, load_sdk, model_folder, obstacle
from mossar_stream.errors import MossarError

CHECKLIST: Final = """\
Checklist for owners of a camera (each step takes a minute):
 1. Stand 2 to 4 m away, head to feet in the picture: mossar view oak:   a skeleton of life size follows, head up.
 2. Raise the LEFT arm: left_wrist goes up. Step towards the camera: z grows by as much as you stepped.
 3. mossar run oak: --stats 5   the rate is near 10 Hz (RVC2) or 24 Hz (RVC4), few gaps; lower it with ?fps=.
 4. Stand still for 10 s: no key frames. Then punch, squat, wave with rests between: key frames at the rests.
 5. Two people side by side keep their names p1 and p2; when one leaves, the other's key frames go on.
 6. Unplug the camera for 10 s and plug it in again: "lost", then "is back", and frames go on.
 7. mossar record oak: take.msk, then mossar run take.msk: the same key frames."""


def check() -> str:
    """Return what is there of the SDK and of cameras, and the checklist for owners of a camera."""
    try:
        lines = [f"depthai {load_sdk().__version__}; models are kept in {model_folder()}"]
        lines += [
            f"camera {info.deviceId or info.name} at {info.name} ({info.platform.name[7:]}): {obstacle(info) or 'ready'}"
            for info in cameras()
        ] or [
            "no OAK camera in sight: plug one in (USB 3 cable, powered port); one on the network may be hidden"
        ]
    except MossarError as error:
        lines = [str(error)]
    return "\n".join([*lines, CHECKLIST])
