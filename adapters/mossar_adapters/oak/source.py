"""OAK cameras as a source: people before a Luxonis camera, found and measured on board, `oak:`.

Each person has the 17 joints of COCO and a `pelvis` between the hips, the root. Axes: right-handed, metres, +x to the
right of the picture, +y up, +z towards the camera; the origin is the camera.

A joint is missing (NaN) where the picture has no depth, which the camera reports as (0, 0, 0) at full confidence;
where the network is less sure than `confidence`, because a hidden joint gets the depth of the object before it; and
farther than `REACH` from the middle of the body, where the depth is that of the wall behind an arm.

The tests run the SDK itself on the host, with its own messages, queues, matching and depth measurement, fed with
synthetic depth pictures, and its download of a model from a hub on the same machine. Only a camera can prove the rest,
which the checklist of `mossar adapters --check oak:` covers: that each kind of camera boots, accepts the pipeline and
reaches its rate, that it stamps depth and pictures with the same clock, that the network's confidence has the meaning
assumed here, the quality of real depth at the edges of a body, and that a camera which was unplugged comes back.
"""

import logging
import queue
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.address import parse_url
from mossar_adapters.files.options import METRES, ReadOptions
from mossar_adapters.joint_sets import COCO_17
from mossar_adapters.live import Counters
from mossar_adapters.oak.camera import ARCHIVES, Camera
from mossar_adapters.oak.identities import Identities, Person
from mossar_adapters.oak.types import CameraError, CameraLost, OakOptions, Picture
from mossar_adapters.source import Meta
from mossar_stream import FrameError, Frames, Skeleton, performer_name

# Below it the network judges a joint rather hidden than visible. Without a floor, hidden joints at the depth of the object
# before them leave 0.39 of the confirmed key frames in place, with it 0.96 (F1, clean depth, six takes).
CONFIDENCE: Final = 0.5
REACH: Final = 1.5  # m; no joint of a person two metres tall is farther from the middle of the body

# Settings to lie under the user's own, chosen on ten takes of the built-in performer before a synthetic camera, measured
# on sixteen others: F1 of the final key frames against the true cuts (within 0.3 s) at 24 and 10 Hz is 0.93 and 0.79 with
# 3 cm of depth noise and holes, without these settings 0.88 and 0.75; with 6 cm, 0.92 and 0.83 against 0.71 and 0.82;
# clean, 0.99 and 0.95 against 0.92 and 0.86. At level `cluster` much less survives noise: 0.65 and 0.29.
DEFAULTS: Final[Mapping[str, object]] = {
    # The jitter of depth adds up in a velocity that sums paths.
    "smoothing": "one_euro",
    # The filter's own 1.5 Hz and 2 Hz per m/s delay moves: 0.90 and 0.77, and key frames while a person stands still.
    # Values from 2 to 4 Hz and from 8 to 30 Hz per m/s are equally good.
    "one_euro_cutoff": 3.0,
    "one_euro_beta": 8.0,
    # A joint that slips onto a wall a metre behind is faster than that, a punch is not. It matters little: 0.88 with
    # such a wall and joints 3 pixels off, as without.
    "max_speed": 10.0,
}

_HIPS: Final = (COCO_17.index("left_hip"), COCO_17.index("right_hip"))
_ROOT: Final = len(COCO_17)
SKELETON: Final = Skeleton(
    (*COCO_17.names, "pelvis"),
    (*(_ROOT if joint in _HIPS else parent for joint, parent in enumerate(COCO_17.parents)), -1),
    _ROOT,
)

OPTIONS: Final = {
    "model": f"a name at the maker's hub, or an archive ({' '.join(ARCHIVES)})",
    "device": "id, address or USB port of a camera",
    "fps": "pictures per second",
    "unit": "m, cm, mm, inch or auto",
    "performer": "name of the first person",
    "confidence": "0 to 1; joints that the network is less sure of are missing",
}
_RATES: Final = (1.0, 120.0)  # Hz
_IDLE: Final = 0.1  # s without a frame after which the reader gets None
_CAPACITY: Final = 256  # items that wait for the reader; then the oldest are dropped
_SHORTEST_PAUSE, _LONGEST_PAUSE = 1.0, 30.0  # s between two attempts to get a lost camera back
_FAREWELL: Final = 3.0  # s that `close` waits for the camera to stop

_log = logging.getLogger("mossar.oak")
Floats = NDArray[np.float64]
Connect = Callable[[OakOptions, Callable[[str], None], Callable[[], bool]], Camera]


class OakCounters(Counters):
    """Counters of the camera: `received` counts pictures, `ignored` people beyond the most.

    Args:
        people: People in all pictures.
        no_depth: Their joints without depth.
        unsure: Their joints that the network was not sure of.
        far_off: Their joints out of reach.
        late: Frames dropped because they were not read in time.
    """

    people: int = 0
    no_depth: int = 0
    unsure: int = 0
    far_off: int = 0
    late: int = 0


class OakSource:
    """People before a camera, as `p1`, `p2`, ...; implements `Source`.

    The camera is opened, read and reopened by a thread of this source's own. If it cannot be opened the first time,
    `items` raises; once it has worked, it is waited for with growing pauses.

    Args:
        options: Which camera, model, rate and unit.
        performer: Name of the first person; the next are called `name_2` and so on.
        confidence: Joints that the network is less sure of are missing.
        name: The URL, for messages.
        connect: Opens the camera; see `Camera.open`.

    Example:
        >>> OakSource.from_url("oak:?device=192.168.1.44&fps=15").options.fps
        15.0
    """

    live = True

    def __init__(
        self,
        options: OakOptions | None = None,
        *,
        performer: str = "p1",
        confidence: float = CONFIDENCE,
        name: str = "oak:",
        connect: Connect = Camera.open,
    ) -> None:
        self.name = name
        self.options = options or OakOptions()
        self.counters = OakCounters()
        self._performer = performer_name(performer)
        self._others = "p" if self._performer == "p1" else f"{self._performer}_"
        self._confidence = confidence
        self._connect = connect
        self._identities = Identities()
        self._latest: int | None = None  # number of the latest picture
        self._fps: float | None = None
        self._doing = "the camera was not opened yet"  # empty while pictures come
        self._since = time.monotonic()  # s; when that began
        self._closing = threading.Event()
        self._inbox: queue.Queue[Frames | Exception | None] = queue.Queue()  # None: ended
        # Not a daemon: Python would end it inside the SDK at the end of the program, which aborts the process.
        self._thread = threading.Thread(target=self._run, name="oak", daemon=False)

    @classmethod
    def from_url(cls, url: str, options: ReadOptions | None = None) -> "OakSource":
        """Return the source that `url` describes, as in `oak:?device=192.168.1.44&fps=15`.

        Args:
            url: Its options go before the others.
            options: The user's fps and unit.

        Raises:
            SettingsError: If an option is unknown or its value impossible; names the legal ones.
        """
        address, options = parse_url(url), options or ReadOptions()
        if address.scheme != "oak" or address.host or address.path:
            raise address.error("it is not of the form oak: or oak:?device=192.168.1.44&fps=15")
        address.check(OPTIONS)
        model, sure = address.options.get("model", ""), address.number("confidence", 0, 1)
        if model.endswith(ARCHIVES) and not Path(model).is_file():
            raise address.error("there is no such model archive")
        if not model.endswith(ARCHIVES) and (model.startswith(("/", ".", "~")) or Path(model).is_file()):
            raise address.error(f"a model is an archive ({' '.join(ARCHIVES)}) or a name at the maker's hub")
        return cls(
            OakOptions(
                model,
                address.options.get("device", ""),
                address.number("fps", *_RATES, options.fps),
                address.choice("unit", ("auto", *METRES), options.unit),
            ),
            performer=address.options.get("performer") or "p1",
            confidence=CONFIDENCE if sure is None else sure,
            name=url,
        )

    def items(self) -> Iterator[Meta | Frames | None]:
        """Yield a meta for each person at first sight, and frames one by one; None when nothing came for 0.1 s.

        To be iterated once.

        Raises:
            CameraError: If the camera cannot be opened.
        """
        announced: set[str] = set()
        self._thread.start()
        while not self._closing.is_set():
            try:
                item = self._inbox.get(timeout=_IDLE)
            except queue.Empty:
                yield None
                continue
            if item is None:
                return
            if isinstance(item, Exception):
                raise item
            if item.performer not in announced:
                announced.add(item.performer)
                yield Meta(item.performer, SKELETON, self._fps)
            yield item

    def explain(self) -> str:
        """Return one line with a likely reason for missing frames."""
        count = self.counters
        text = self._doing and f"{self._doing} (for {time.monotonic() - self._since:.0f} s)"
        if not text and not count.people:
            text = (
                f"{count.received} pictures came without a person; stand 2 to 4 m away, head to feet in view"
            )
        elif not text:
            text = (
                f"{count.people} people in {count.received} pictures; of their joints {count.no_depth} were "
                f"without depth, {count.unsure} unsure, {count.far_off} out of reach"
            )
        return f"{self.name}: {text}" + (f"; last problem: {count.last_error}" if count.last_error else "")

    def close(self) -> None:
        """Release the camera; `items` ends soon after. May be called twice, and from any thread."""
        again = self._closing.is_set()
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join(_FAREWELL)
        if self._thread.is_alive() and not again:
            _log.warning("%s: %s; the SDK does not stop at once, please wait", self.name, self._doing)

    def _run(self) -> None:
        """Keep a camera open until the source is closed; errors are raised where frames are read."""
        try:
            self._keep_open()
        except Exception as error:  # noqa: BLE001 - handed over
            self._inbox.put(error)
        else:
            self._inbox.put(None)

    def _keep_open(self) -> None:
        pause, worked = _SHORTEST_PAUSE, False
        while not self._over():
            try:
                camera = self._connect(self.options, self._say, self._over)
                worked = True
                self._read(camera)
            except CameraLost as error:
                if self._latest is not None:
                    pause = _SHORTEST_PAUSE
                self._latest = None
                self._log_news(f"the camera was lost ({error}); waiting for it to come back")
            except CameraError as error:
                if not worked:
                    raise
                self.counters.last_error = str(error)
            until = time.monotonic() + pause
            while time.monotonic() < until and not self._over():
                self._closing.wait(_IDLE)
            pause = min(2 * pause, _LONGEST_PAUSE)

    def _over(self) -> bool:
        """Return whether to stop: the source was closed, or the program ends without having closed it."""
        return self._closing.is_set() or not threading.main_thread().is_alive()

    def _read(self, camera: Camera) -> None:
        """Read a camera until the source is closed.

        Raises:
            CameraLost: If the camera is gone.
        """
        self._fps = camera.fps
        self._say(f"camera {camera.name} runs and has sent no picture yet")
        try:
            while not self._over():
                try:
                    picture = camera.get(_IDLE)
                    if picture is not None:
                        self._take(picture)
                except FrameError as error:
                    self.counters.reject(str(error))
        finally:
            camera.close()

    def _take(self, picture: Picture) -> None:
        """Pass on the people of one picture."""
        if self._latest is not None:
            self.counters.gaps += max(0, picture.number - self._latest - 1)
        elif self.counters.received:
            self._log_news("the camera is back")
        self._latest = picture.number
        self._doing = ""
        self.counters.received += 1
        poses = [pose for pose in map(self._usable, picture.people) if pose is not None]
        places = [_place(pose) for pose in poses]
        for pose, person in zip(poses, self._identities.follow(places, picture.time), strict=True):
            if person is None:
                self.counters.ignored += 1
            else:
                self._pass_on(pose, person, picture.time)

    def _usable(self, found: Floats) -> Floats | None:
        """Return a person's joints as (17, 4), missing ones NaN at confidence 0; None if all are missing."""
        if found.shape != (_ROOT, 4):
            self.counters.reject(
                f"a person with {len(found)} joints; the model must give the {_ROOT} of COCO"
            )
            return None
        self.counters.people += 1
        pose, missing = clean(found, self._confidence)
        for name, joints in missing.items():
            setattr(self.counters, name, getattr(self.counters, name) + int(joints.sum()))
        return pose if pose[:, 3].any() else None

    def _pass_on(self, pose: Floats, person: Person, moment: float) -> None:
        name = self._performer if person.number == 1 else f"{self._others}{person.number}"
        frame = np.vstack([pose, _pelvis(pose, person)])[None].astype(np.float32)
        if self._inbox.qsize() >= _CAPACITY:
            with suppress(queue.Empty):
                self._inbox.get_nowait()
                self.counters.late += 1
        self._inbox.put(Frames(frame[:, :, :3].copy(), np.array([moment]), frame[:, :, 3].copy(), name))

    def _say(self, doing: str) -> None:
        """Note the current step, for `explain` and the log."""
        self._doing, self._since = doing, time.monotonic()
        _log.info("%s: %s", self.name, doing)

    def _log_news(self, news: str) -> None:
        """Log that the camera is lost or back."""
        self._doing, self._since = news, time.monotonic()
        _log.warning("%s: %s", self.name, news)


def clean(found: Floats, confidence: float) -> tuple[Floats, dict[str, NDArray[np.bool_]]]:
    """Return the joints of a person with y up, and the missing ones for each reason.

    Args:
        found: (17, 4) as in `Picture`: x to the right, y down, z away from the camera, metres, and the confidence.
        confidence: Joints that the network is less sure of are missing.

    Returns:
        (17, 4): x to the right, y up, z towards the camera, NaN at confidence 0 where a joint is missing; and the
        (17,) masks `no_depth`, `unsure` and `far_off`.
    """
    pose = found * (1.0, -1.0, -1.0, 1.0)
    pose[pose[:, 3] < 0, 3] = 1.0  # the network gives no confidence
    no_depth = ~(np.isfinite(found).all(1) & (found[:, 2] > 0))
    unsure = ~no_depth & (pose[:, 3] < confidence)
    pose[no_depth | unsure] = np.nan
    far_off = np.zeros_like(unsure)
    if not (no_depth | unsure).all():
        middle = np.nanmedian(pose[:, :3], axis=0)
        far_off = np.linalg.norm(pose[:, :3] - middle, axis=1) > REACH
        pose[far_off] = np.nan
    pose[np.isnan(pose[:, 0])] = (np.nan, np.nan, np.nan, 0.0)
    return pose, {"no_depth": no_depth, "unsure": unsure, "far_off": far_off}


def _place(pose: Floats) -> Floats:
    """Return the place of a person, (3,) metres: between the hips, or in the middle of the joints that are present."""
    hips: Floats = pose[_HIPS, :3].mean(0)
    return hips if np.isfinite(hips).all() else np.nanmedian(pose[:, :3], axis=0)


def _pelvis(pose: Floats, person: Person) -> Floats:
    """Return the middle of the hips as (4,); of one hip and the last known width while the other is missing.

    Without that, a person seen from the side would have no root, and no motion.
    """
    left, right = pose[_HIPS, :]
    if left[3] and right[3]:
        person.half_hips = (right[:3] - left[:3]) / 2
        return np.append((left[:3] + right[:3]) / 2, min(left[3], right[3]))
    if person.half_hips is None or not (left[3] or right[3]):
        return np.array([np.nan, np.nan, np.nan, 0.0])
    if left[3]:
        return np.append(left[:3] + person.half_hips, left[3])
    return np.append(right[:3] - person.half_hips, right[3])
