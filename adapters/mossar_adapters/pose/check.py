"""The webcams and weights of this computer, and the result of one picture."""

import time
from typing import Final

from mossar_adapters.address import parse_url
from mossar_adapters.extras import needed
from mossar_adapters.pose.camera import Camera, Taken, cameras
from mossar_adapters.pose.source import wanted
from mossar_adapters.pose.types import PoseError
from mossar_adapters.pose.weights import GET, MODELS, folder, kept
from mossar_stream import MossarError

PATIENCE: Final = 5.0  # s that a camera has for its first picture
_VISIBLE: Final = 0.5
_LOOKS: Final = 5  # pictures in which a person is looked for; the first ones of a camera are dark


def check(url: str = "webcam:") -> tuple[str, bool]:
    """Return the cameras, the weights and the result of a picture, and whether the camera can be used.

    Args:
        url: As for a source.

    Raises:
        SettingsError: If an option is unknown or its value impossible.
    """
    options, model, _ = wanted(parse_url(url))
    lines: list[str] = []
    try:
        needed("cv2", "webcam", "a webcam (webcam:)")
        lines += summary()
        camera = Camera(options)
        try:
            lines.append(_look(camera, model))
        finally:
            camera.close()
    except MossarError as error:
        return "\n".join([*lines, str(error)]), False
    return "\n".join(lines), True


def summary() -> list[str]:
    """Return a line for each camera that the system lists, and one for the weights."""
    seen = [f"camera {found.number}: {found.name or 'without a name'}" for found in cameras()]
    there = [model for model in MODELS if kept(model) is not None]
    weights = (
        f"weights in {folder()}: {', '.join(there)}" if there else f"no weights yet; to fetch them: {GET}"
    )
    return [*(seen or ["the system lists no camera"]), weights]


def _look(camera: Camera, model: str) -> str:
    """Return the result of a camera's pictures."""
    taken = _picture(camera)
    height, width = taken.picture.shape[:2]
    rate = f" at {camera.fps:g} Hz" if camera.fps else ""
    found = f"camera {camera.device}: a picture of {width} x {height}{rate}"
    weights = kept(model)
    if weights is None:
        return f"{found}; no weights of model {model} yet"
    from mossar_adapters.pose.following import Estimator

    estimator = Estimator(weights)
    for _ in range(_LOOKS):
        began = time.perf_counter()
        bodies = estimator.estimate(taken.picture, taken.time)
        spent = time.perf_counter() - began
        if bodies:
            visible = int((bodies[0].confidence >= _VISIBLE).sum())
            joints = len(bodies[0].confidence)
            return f"{found}; a person with {visible} of {joints} joints in view, in {spent * 1e3:.0f} ms"
        taken = _picture(camera)
    return f"{found}; no person was found in it"


def _picture(camera: Camera) -> Taken:
    taken = camera.newest(PATIENCE)
    if taken is None:
        raise PoseError(f"camera {camera.device}: no picture came within {PATIENCE:g} s")
    return taken
