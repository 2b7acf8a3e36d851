"""`mossar run` as a process of its own, as other programs see it: started, asked over `--control`, stopped."""

import json
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Sequence
from types import TracebackType
from typing import IO, Any, Self

import msgspec
import zmq

from mossar_stream import MossarError

START = 30.0  # s that starting may take on a busy machine
_ANSWER = 10.0  # s
_LOOK = 0.05  # s between two looks


class RunProcess:
    """A `mossar run` that is ready for frames when the block begins.

    Args:
        source: URL to listen to.
        sink: URL for events, or `-` for lines that are left in `lines`.
        options: Further options of `mossar run`.
    """

    def __init__(
        self, source: str, sink: str, *options: str, output: IO[bytes] | int = subprocess.DEVNULL
    ) -> None:
        self._control = f"zmq+bind://127.0.0.1:{free_port()}"
        command = [sys.executable, "-m", "mossar_tools", "run", source, "--to", sink, "--quiet", *options]
        self._command = [*command, "--control", self._control]
        self._output = output
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Self:
        self._process = subprocess.Popen(self._command, stdin=subprocess.DEVNULL, stdout=self._output)  # noqa: S603
        try:
            self.ask({"get": "settings"}, START)
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()

    def ask(self, request: dict[str, Any], patience: float = _ANSWER) -> Any:
        """Return the value of the answer to a control request.

        Raises:
            MossarError: If the run has ended, does not answer, or cannot do it.
        """
        with self._context.socket(zmq.REQ) as asking:
            asking.setsockopt(zmq.LINGER, 0)
            asking.connect(self._control.replace("zmq+bind", "tcp"))
            asking.send(msgspec.json.encode(request))
            until = time.monotonic() + patience
            while not asking.poll(int(_LOOK * 1000)):
                if self._process is None or self._process.poll() is not None or time.monotonic() > until:
                    raise MossarError("mossar run does not answer")
            answer = json.loads(asking.recv())
        if not answer["ok"]:
            raise MossarError(answer["error"])
        return answer["value"]

    def settled_stats(self, quiet: float = 0.5) -> dict[str, dict[str, Any]]:
        """Return the stats of all performers when no frame has come for `quiet` seconds."""
        stats, since = self.ask({"get": "stats"}), time.monotonic()
        while time.monotonic() - since < quiet:
            time.sleep(_LOOK)
            latest = self.ask({"get": "stats"})
            if _frames(latest) != _frames(stats):
                since = time.monotonic()
            stats = latest
        found: dict[str, dict[str, Any]] = stats
        return found

    def _end(self) -> None:
        if self._process is not None:
            self._process.send_signal(signal.SIGINT if sys.platform != "win32" else signal.SIGTERM)
            try:
                self._process.wait(_ANSWER)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._context.term()


def free_port(kind: socket.SocketKind = socket.SOCK_STREAM) -> int:
    """Return a port that is free at this moment."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def _frames(stats: dict[str, dict[str, Any]]) -> Sequence[int]:
    return [found["frames"] for found in stats.values()]
