"""Eye: the camera of the browser as the sensor; poses are estimated in the page, pictures do not leave it."""

import contextlib
import json
import socket
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from mossar_adapters.maps.codec import to_json
from mossar_adapters.maps.frame_maps import map_of_meta
from mossar_adapters.pose.task import write_task
from mossar_adapters.pose.types import SKELETON
from mossar_adapters.pose.weights import LIBRARY, MODELS, folder, kept, library, weights
from mossar_adapters.source import Meta
from mossar_tools.console import LOGGER
from mossar_tools.dashboard.visitors import HERE
from mossar_tools.player_page.content import Content
from mossar_tools.player_page.outline import outline_of

_PERFORMER: Final = "p1"


class Eye:
    """The weights and the maker's library for the page, and the port to which it sends poses.

    Args:
        model: To begin with.

    Raises:
        MossarError: If the weights or the library cannot be had.
    """

    def __init__(self, model: str) -> None:
        weights(model, LOGGER.info)
        place = library(LOGGER.info)
        models = [name for name in MODELS if kept(name) is not None]
        self.port = _free_port()
        self.line = f"ws://{HERE}:{self.port}"
        outline = outline_of(SKELETON)
        self.about: Mapping[str, Any] = {
            "poses": self.line,
            "model": model,
            "models": models,
            "meta": json.loads(to_json(map_of_meta(Meta(_PERFORMER, SKELETON)))),
            "outline": {**outline.drawn(), "places": outline.places},
        }
        found: dict[str, Content] = {f"/{file.file}": (place / file.file).read_bytes for file in LIBRARY}
        self.files: Mapping[str, Content] = found | {f"/{name}.task": _task_of(name) for name in models}

    def source(self, port: int) -> str:
        """Return the URL of the source to which the page at a port sends poses, and no other page may."""
        return f"ws+bind://{HERE}:{self.port}?origin=http://{HERE}:{port},http://localhost:{port}"


def _task_of(model: str) -> Content:
    """Return a function that makes the bundle of a model, once, and reads it."""

    def read() -> bytes:
        found = weights(model)
        path: Path = folder() / f"pose_{model}.task"
        if not path.exists() or path.stat().st_mtime < found.landmarks.stat().st_mtime:
            write_task(found, path)
        return path.read_bytes()

    return read


def _free_port() -> int:
    """Return a free port of this computer."""
    with contextlib.closing(socket.socket()) as taken:
        taken.bind((HERE, 0))
        return int(taken.getsockname()[1])
