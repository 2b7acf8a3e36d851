"""Stage: performers come and go, and send their frames over a network that is not to be relied on."""

import math
import random
import threading
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from checks.soak import strangers
from checks.soak.faults import Faults
from checks.soak.truth import Truth
from mossar_adapters.address import parse_url
from mossar_adapters.demo import DemoSource
from mossar_adapters.maps.codec import to_msgpack
from mossar_adapters.maps.frame_maps import FrameMap
from mossar_adapters.source import Meta
from mossar_adapters.zeromq.sink import Publisher
from mossar_stream import Frames

FPS = 60.0
MAX_PAUSE = 20.0  # s; longer than a busy machine may keep a sender waiting
NAMES = tuple(f"p{k}" for k in range(1, 25))
TOGETHER = 3  # performers on stage
_STRETCH = 600  # frames of each performer, between two changes on stage
_FLOW, _BURST = 300, 1200  # frames under way: usually, and in a burst; the pipeline's queue holds 2048
_PATIENCE = 60.0  # s that frames may be under way
_FAR = 10_000.0  # m from the origin that a performer may stand
_AWAY = 2000.0  # s by which the clock of a performer who comes back has gone on


class Stage:
    """Sends in a thread of its own.

    Args:
        url: Where the pipeline listens.
        truth: Gets everything that is sent.
        arrived: Returns the frames that the pipeline has taken.
        seed: The same seed makes the same faults.
    """

    def __init__(self, url: str, truth: Truth, arrived: Callable[[], int], seed: int) -> None:
        rng = self._rng = random.Random(seed)  # noqa: S311 - not for secrets
        self.faults = Faults(rng)
        self.sent = 0  # frames
        self.error: Exception | None = None
        self.meta, self._motions = _motions(seed)
        self._truth, self._arrived = truth, arrived
        self._clock = dict.fromkeys(NAMES, 0.0)  # of each sender, s
        self._on_stage: list[str] = []
        self._places: dict[str, tuple[float, NDArray[np.float64]]] = {}  # rad about the vertical, (3,) m
        self._flood_due = 0.0  # monotonic s
        self._publisher = Publisher(parse_url(url))
        self.performing = threading.Event()  # set when all strangers of the beginning have come
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._play, name="stage", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """End the act; all performers leave."""
        self._stopped.set()

    @property
    def playing(self) -> bool:
        """Whether a performer has not left yet, or a take has not ended."""
        return self._thread.is_alive()

    def close(self) -> None:
        """Release the socket."""
        self._thread.join()
        self._publisher.close()

    def _play(self) -> None:
        try:
            self._publisher.await_subscriber(_PATIENCE)
            for _ in range(strangers.WAVES):
                self._flood(strangers.FIRST)
                time.sleep(strangers.MOMENT)
            for name in NAMES:
                self._publisher.announce(self.meta[name])
                self._end_take(
                    name
                )  # all performers are announced at the beginning: nothing is to grow later
                self._truth.leave(name)  # on a slow machine the wall clock ends some of these takes
            self._flood(strangers.FIRST)
            self._wait_until_under_way(0)
            self.performing.set()
            while not self._stopped.is_set():
                if time.monotonic() > self._flood_due:
                    self._flood(strangers.LATER)
                self._change_performers()
                self._perform()
            for name in NAMES:
                self._end_take(name)
            self._wait_until_under_way(0)
        except Exception as error:  # noqa: BLE001 - the main thread raises it
            self.error = error

    def _change_performers(self) -> None:
        """Let one performer go and another one come."""
        if len(self._on_stage) == TOGETHER:
            self._truth.leave(self._on_stage.pop(0))
            self.faults.injected["performers left"] += 1
        coming = self._rng.choice([name for name in NAMES if name not in self._on_stage])
        self._on_stage.append(coming)
        self._publisher.announce(
            self.meta[coming]
        )  # a performer that was silent for long may have been forgotten
        self._places[coming] = self._place()
        self._clock[coming] += _AWAY  # ends the take before, unless the wall clock has done so

    def _place(self) -> tuple[float, NDArray[np.float64]]:
        """Return the heading and the place of a performer on stage."""
        if self._rng.random() < 0.5:
            return 0.0, np.zeros(3)
        self.faults.injected["turned and shifted"] += 1
        x, z = self._rng.uniform(-_FAR, _FAR), self._rng.uniform(-_FAR, _FAR)
        return self._rng.uniform(0.0, 2 * math.pi), np.array([x, 0.0, z])

    def _flood(self, count: int) -> None:
        """Send strangers that never come again; they replace the performers idle for longest."""
        self.faults.injected["strangers"] += count
        pose = np.array([[0, 1, 0], [0.3, 1, 0]], np.float32)
        for i, name in enumerate(strangers.names(self._rng, count)):
            self._publisher.announce(strangers.meta(name))
            self._send(name, pose, 0.0)
            if i % 20 == 0:
                self._wait_until_under_way(_FLOW)
        self._flood_due = time.monotonic() + strangers.PERIOD

    def _end_take(self, name: str) -> None:
        """Send a frame that is so late that it ends the take before."""
        moment, pose = self._clock[name] + _AWAY, self._motions[0][:1]
        self._clock[name] = moment
        self._truth.follow(name, pose, np.array([moment]))
        self._send(name, pose[0], moment)

    def _perform(self) -> None:
        """Send a stretch of frames of all performers on stage, frame by frame in turn."""
        delivered = {}
        for name in self._on_stage:
            if name != self._on_stage[-1]:
                self._clock[name] += self.faults.clock_jump()
            motion = self._rng.choice(self._motions)
            begin = self._rng.randrange(len(motion) - _STRETCH)
            times = self._clock[name] + np.arange(1, _STRETCH + 1) / FPS
            self._clock[name] = float(times[-1])
            frames = placed(motion[begin : begin + _STRETCH], *self._places[name])
            delivered[name] = self.faults.deliver(frames, times)
            self._truth.follow(name, *delivered[name])
        luck = self._rng.random()
        limit = _BURST if luck < 0.1 else _FLOW
        self.faults.injected["bursts"] += luck < 0.1
        for i in range(max((len(times) for _, times in delivered.values()), default=0)):
            for name, (positions, times) in delivered.items():
                if i < len(times):
                    self._send(name, positions[i], float(times[i]))
            if i % 100 == 0:
                self._wait_until_under_way(limit)
        if luck > 0.98:
            self.faults.injected["stalls"] += 1
            time.sleep(0.5)

    def _send(self, name: str, positions: NDArray[np.float32], moment: float) -> None:
        if self._rng.random() < 0.001:
            self.faults.injected["rubbish"] += 1
            self._publisher.put(b"mossar.frame.p1.", self._rng.randbytes(40))
        found = FrameMap(name, self.sent, moment, positions.shape, positions.tobytes())
        self._publisher.put(f"mossar.frame.{name}.".encode(), to_msgpack(found))
        self.sent += 1

    def _wait_until_under_way(self, most: int) -> None:
        """Wait until at most so many frames are under way."""
        give_up = time.monotonic() + _PATIENCE
        while self.sent - self._arrived() > most:
            if time.monotonic() > give_up:
                raise TimeoutError(f"{self.sent - self._arrived()} frames did not arrive")
            time.sleep(0.002)


def placed(positions: NDArray[np.float32], angle: float, shift: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return positions turned about the vertical (y) and shifted.

    Args:
        positions: (n, J, 3) m.
        angle: rad.
        shift: (3,) m.
    """
    cos, sin = math.cos(angle), math.sin(angle)
    turn = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
    there: NDArray[np.float64] = positions @ turn.T + shift
    return there.astype(np.float32)


def _motions(seed: int) -> tuple[dict[str, Meta], list[NDArray[np.float32]]]:
    """Return a meta for each performer, and the motions."""
    chunks: dict[str, list[NDArray[np.float32]]] = {}
    skeleton = None
    for item in DemoSource(seed, performers=4, seconds=120, speed="max").items():
        if isinstance(item, Meta):
            skeleton = item.skeleton
        elif isinstance(item, Frames):
            chunks.setdefault(item.performer, []).append(item.positions)
    if skeleton is None:
        raise ValueError("the built-in performer announces itself")
    return {name: Meta(name, skeleton) for name in NAMES}, [np.concatenate(c) for c in chunks.values()]
