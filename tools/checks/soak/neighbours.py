"""Neighbours: clients that connect and send nothing, and threads that misuse shared objects."""

import contextlib
import http.client
import socket
import threading
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.demo.body import SKELETON
from mossar_stream import Event, Performers, Segmenter

_IDLE = 40  # silent connections to each server; more than the one for metrics keeps
_PERIOD = 1.0  # s between two looks at them
_MISUSES = 5  # looks between two misuses
Push = Callable[[NDArray[np.float32], NDArray[np.float64]], list[Event]]


class Neighbours:
    """Sits beside the pipeline in a thread of its own.

    Args:
        metrics: Port of the server for metrics.
        others: Ports of other servers.
    """

    def __init__(self, metrics: int, *others: int) -> None:
        self.counted: Counter[str] = Counter()
        self.faults: list[str] = []
        self._metrics = metrics
        self._idle = IdleClients([metrics, *others], self.counted)
        self._misuse = Misuse(self.counted)
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, name="neighbours", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """End."""
        self._stopped.set()
        self._thread.join()

    def _run(self) -> None:
        looks = 0
        while not self._stopped.wait(_PERIOD if looks else 0.0):
            self._idle.look()
            if not is_answered(self._metrics):
                self.faults.append("nobody answered who asked for metrics")
            if looks % _MISUSES == 0:
                self.faults += self._misuse.try_once()
            looks += 1
        self._idle.close()
        self._misuse.close()


class IdleClients:
    """Connects to servers, stays silent, and connects again after each disconnection.

    Args:
        ports: Of the servers.
        counted: Gets the number of connections.
    """

    def __init__(self, ports: list[int], counted: Counter[str]) -> None:
        self._counted = counted
        self._ports = ports
        self._open: list[socket.socket] = []

    def look(self) -> None:
        """Replace missing neighbours; called now and then."""
        self._open = [client for client in self._open if not _is_over(client)]
        for port in self._ports:
            for _ in range(_IDLE - sum(_port_of(client) == port for client in self._open)):
                with contextlib.suppress(OSError):
                    self._open.append(socket.create_connection(("127.0.0.1", port), timeout=1.0))
                    self._counted["idle clients"] += 1

    def close(self) -> None:
        """Leave."""
        for client in self._open:
            client.close()


def _port_of(client: socket.socket) -> int:
    try:
        return int(client.getpeername()[1])
    except OSError:
        return -1


def _is_over(client: socket.socket) -> bool:
    """Return whether a connection was ended by its server; close it then."""
    client.setblocking(False)
    try:
        over = client.recv(1) == b""
    except BlockingIOError:
        return False
    except OSError:
        over = True
    if over:
        client.close()
    return over


def is_answered(port: int) -> bool:
    """Return whether a server of metrics answers a request, however many idle clients stay connected."""
    try:
        asking = http.client.HTTPConnection("127.0.0.1", port, timeout=5.0)
        asking.request("GET", "/metrics")
        answer = asking.getresponse().read()
        asking.close()
    except OSError:
        return False
    return b"mossar_frames_total" in answer


class Misuse:
    """Lets two threads share a segmenter, and a pool: that must be reported at once, and do no harm.

    Args:
        counted: Gets the number of refusals.
        frames: That each thread pushes.
    """

    def __init__(self, counted: Counter[str], frames: int = 20_000) -> None:
        self._counted = counted
        self._still = np.zeros((frames, len(SKELETON), 3), np.float32)
        self._still[:, 1:] = 1.0
        self._times = np.arange(frames) / 1e5
        # The same two all along: every new one would have memory of its own.
        self._threads = ThreadPoolExecutor(2)

    def close(self) -> None:
        """End the threads, but for one that hangs."""
        self._threads.shutdown(wait=False)

    def try_once(self) -> list[str]:
        """Misuse a new segmenter and a new pool; return the faults."""
        segmenter, pool = Segmenter(SKELETON), Performers()
        pool.announce("ann", SKELETON)
        faults = []
        for push in (segmenter.push, lambda p, t: pool.push_many(["ann"], p[None], t)):
            begin = threading.Barrier(2)
            try:
                done = [self._threads.submit(self._push, push, begin) for _ in range(2)]
                faults += [fault for one in done if (fault := one.result(60.0))]
            except TimeoutError:
                return [*faults, "a thread that shared a segmenter did not come back"]
            push(self._still[:2], 100.0 + self._times[:2])  # it goes on
        return faults

    def _push(self, push: Push, begin: threading.Barrier) -> str:
        """Push when the other thread does; return the fault, empty if there is none."""
        begin.wait(30.0)
        try:
            push(self._still, self._times)
        except RuntimeError as error:
            self._counted["threads refused"] += 1
            return "" if "two threads" in str(error) else str(error)
        except Exception as error:  # noqa: BLE001 - any other is a fault
            return f"{type(error).__name__} where threads shared a segmenter: {error}"
        return ""
