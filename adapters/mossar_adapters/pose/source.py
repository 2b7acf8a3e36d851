"""A webcam as a source: people before it, estimated on this computer, `webcam:`.

Each person has the 33 joints of BlazePose; axes as in `types.Body`. A picture without a person gives no frame, so that
an empty room gives no event. Pictures are neither stored nor sent: they stay in this process until the next one comes.
"""

import logging
import threading
import time
from collections.abc import Callable, Iterator
from typing import Final

import msgspec
import numpy as np

from mossar_adapters.address import Address
from mossar_adapters.extras import needed
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.live import Counters
from mossar_adapters.people import People
from mossar_adapters.pose.camera import Camera, Taken, check_camera
from mossar_adapters.pose.pictures import Picture
from mossar_adapters.pose.types import MAX_PEOPLE, SKELETON, Body, CameraOptions, PoseError
from mossar_adapters.pose.weights import MODELS, USUAL, weights
from mossar_adapters.source import Meta
from mossar_stream import Frames, performer_name

OPTIONS: Final = {
    "name": "part of the name of a camera; mossar adapters --check webcam: lists them",
    "model": "lite, full or heavy; default: full",
    "size": "WIDTHxHEIGHT in pixels, as 640x480",
    "fps": "pictures per second",
    "people": "how many people to look for, 1 to 4; default: as many as --people has slots, else 1",
    "performer": "name of the first person",
    "picture": "yes: the dashboard shows the picture, mirrored, with the skeleton on it",
}
BROWSER: Final = "browser"  # in place of a number: the camera of the browser, on the page of `mossar view`
_RATES: Final = (1.0, 240.0)  # Hz
_SIDES: Final = (64, 8192)  # pixels
_IDLE: Final = 0.1  # s without items after which the reader gets None
_SHORTEST_PAUSE, _LONGEST_PAUSE = 0.5, 10.0  # s between two attempts to get a lost camera back

_log = logging.getLogger("mossar.webcam")


class WebcamCounters(Counters):
    """Counters of the camera: `received` counts pictures.

    Args:
        people: People in all pictures.
        late: Pictures that were replaced by the next one before they were estimated.
    """

    people: int = 0
    late: int = 0


class Seen(msgspec.Struct, frozen=True):
    """The latest picture, for a preview on this computer.

    Args:
        picture: (h, w, 3), BGR.
        bodies: People in it.
    """

    picture: Picture
    bodies: tuple[Body, ...]


class WebcamSource:
    """People before a webcam, as `p1`, `p2`, ...; implements `Source`.

    Args:
        options: Which camera.
        model: `lite`, `full` or `heavy`.
        people: How many to follow.
        performer: Name of the first person; the next are called `name_2` and so on.
        keep_picture: Whether `seen` holds the latest picture.
        name: The URL, for messages.

    Attributes:
        seen: The latest picture and the people in it, if pictures are kept.

    Raises:
        MossarError: If there is no such camera, the weights cannot be had, or the extra `webcam` is not installed.
    """

    live = True

    def __init__(
        self,
        options: CameraOptions | None = None,
        *,
        model: str = USUAL,
        people: int = 1,
        performer: str = "p1",
        keep_picture: bool = False,
        name: str = "webcam:",
    ) -> None:
        for library in ("cv2", "ai_edge_litert"):
            needed(library, "webcam", "a webcam (webcam:)")
        from mossar_adapters.pose.following import Estimator

        self.name = name
        self.options = options or CameraOptions()
        check_camera(self.options)  # before anything is fetched for it
        self.counters = WebcamCounters()
        self.seen: Seen | None = None
        self.keeps_picture = keep_picture
        self._performer = performer_name(performer)
        self._others = "p" if self._performer == "p1" else f"{self._performer}_"
        self._estimator = Estimator(weights(model, _log.info), people)
        self._doing = "the camera was not opened yet"  # empty while pictures come
        self._closing = threading.Event()
        self._camera: Camera | None = None  # None while it is lost
        self._last = -1  # number of the latest picture
        # s, and monotonic s of the next attempt to get it back.
        self._pause, self._again = (
            _SHORTEST_PAUSE,
            0.0,
        )

    @classmethod
    def from_address(
        cls, address: Address, options: ReadOptions | None = None, slots: People | None = None
    ) -> "WebcamSource":
        """Return the source that a URL describes, as `webcam:1?model=lite&size=640x480`.

        Args:
            address: Its options take precedence over the others.
            options: The user's fps.
            slots: Choice of slots, which is also the number of people to find, at most 4; 4 for `nearest` and `first`.

        Raises:
            SettingsError: If an option is unknown or its value impossible; names the legal ones.
            MossarError: See the class.
        """
        camera, model, people = wanted(address, options, slots)
        return cls(
            camera,
            model=model,
            people=people,
            performer=address.options.get("performer") or "p1",
            keep_picture=address.choice("picture", ("yes", "no"), "no") == "yes",
            name=address.url,
        )

    @property
    def preview(self) -> Callable[[], Seen | None] | None:
        """Function that returns the latest picture, if the user wants it; None if pictures are not kept."""
        return (lambda: self.seen) if self.keeps_picture else None

    def keep_pictures(self) -> None:
        """Keep the latest picture from now on, so that `preview` returns it."""
        self.keeps_picture = True

    def items(self) -> Iterator[Meta | Frames | None]:
        """Yield a meta for each person at first sight, and frames one by one; None when nothing came for 0.1 s.

        To be iterated once.

        Raises:
            PoseError: If the camera cannot be opened; one that worked is waited for.
        """
        announced: set[str] = set()
        self._camera = Camera(self.options)
        try:
            while not self._closing.is_set():
                taken = self._newest()
                if taken is None:
                    yield None
                else:
                    yield from self._frames(taken, announced)
        finally:
            self.seen = None
            if self._camera is not None:
                self._camera.close()

    def explain(self) -> str:
        """Return one line with a likely reason for missing frames."""
        count = self.counters
        text = self._doing
        if not text and not count.people:
            text = f"{count.received} pictures came without a person; step back until your hips are in view"
        elif not text:
            text = f"{count.people} people in {count.received} pictures; {count.late} pictures came too soon"
        return f"{self.name}: {text}" + (f"; last problem: {count.last_error}" if count.last_error else "")

    def close(self) -> None:
        """Release the camera; `items` ends soon after. May be called twice, and from any thread."""
        self._closing.set()

    def _newest(self) -> Taken | None:
        """Return the newest picture, None if there is none yet, or the camera is lost."""
        if self._camera is None:
            self._closing.wait(_IDLE)
            self._reopen()
            return None
        try:
            return self._camera.newest(_IDLE)
        except PoseError as error:
            if not self.counters.received:
                raise  # it never worked
            self._lose(self._camera, error)
            return None

    def _lose(self, camera: Camera, error: PoseError) -> None:
        """Wait for a camera to come back, with growing pauses."""
        camera.close()
        if self._last >= 0:
            self._pause = _SHORTEST_PAUSE
            self._log_news(f"camera {camera.device} was lost ({error}); waiting for it to come back")
        else:
            self.counters.last_error = str(error)
            self._pause = min(2 * self._pause, _LONGEST_PAUSE)
        self._camera, self._last = None, -1
        self._again = time.monotonic() + self._pause
        self._estimator.forget()

    def _reopen(self) -> None:
        """Try to get a lost camera back."""
        if time.monotonic() < self._again:
            return
        try:
            self._camera = Camera(self.options)
        except PoseError as error:
            self.counters.last_error = str(error)
            self._pause = min(2 * self._pause, _LONGEST_PAUSE)
            self._again = time.monotonic() + self._pause

    def _frames(self, taken: Taken, announced: set[str]) -> Iterator[Meta | Frames]:
        """Yield the people in a picture."""
        if self._last < 0 and self._doing:
            back = self.counters.received > 0
            (self._log_news if back else _log.info)("the camera is back" if back else "the camera runs")
        self._doing = ""
        self.counters.received += 1
        self.counters.late += max(0, taken.number - self._last - 1)
        self._last = taken.number
        bodies = self._estimator.estimate(taken.picture, taken.time)
        self.counters.people += len(bodies)
        if self.keeps_picture:
            self.seen = Seen(taken.picture, tuple(bodies))
        for body in bodies:
            name = self._performer if body.number == 1 else f"{self._others}{body.number}"
            if name not in announced:
                announced.add(name)
                yield Meta(name, SKELETON, self._camera.fps if self._camera else None)
            yield Frames(body.positions[None], np.array([taken.time]), body.confidence[None], name)

    def _log_news(self, news: str) -> None:
        self._doing = news
        _log.warning("%s: %s", self.name, news)


def _size(address: Address) -> tuple[int, int] | None:
    """Return the width and height in a URL."""
    given = address.options.get("size")
    if given is None:
        return None
    sides = given.lower().split("x")
    if len(sides) != 2 or not all(side.isdecimal() and _SIDES[0] <= int(side) <= _SIDES[1] for side in sides):
        raise address.error(f"size is WIDTHxHEIGHT, {_SIDES[0]} to {_SIDES[1]} pixels each, as 640x480")
    return int(sides[0]), int(sides[1])


def wanted(
    address: Address, options: ReadOptions | None = None, slots: People | None = None
) -> tuple[CameraOptions, str, int]:
    """Return the camera, the model and the number of people in a URL.

    Args:
        address: `webcam:`, `webcam:1`, `webcam:/dev/video2`, with options.
        options: The user's fps.
        slots: Choice of slots; see `WebcamSource.from_address`.

    Raises:
        SettingsError: If an option is unknown or its value impossible; names the legal ones.
    """
    address.check(OPTIONS)
    if address.path == BROWSER:
        raise address.error("the browser's camera needs its page; type: mossar view webcam:browser")
    if address.host:
        raise address.error("a camera is a number or a path: webcam:, webcam:1, webcam:/dev/video2")
    named = address.options.get("name", "")
    if named and address.path:
        raise address.error("a camera is named by its number or by name=, not by both")
    usual = 1 if slots is None else min(slots, MAX_PEOPLE) if isinstance(slots, int) else MAX_PEOPLE
    people = address.choice("people", tuple(str(n + 1) for n in range(MAX_PEOPLE)), str(usual))
    fps = address.number("fps", *_RATES, (options or ReadOptions()).fps)
    camera = CameraOptions(address.path or "0", named, _size(address), fps)
    return camera, address.choice("model", tuple(MODELS), USUAL), int(people)
