"""Metrics of a running pipeline for Prometheus, over HTTP."""

import contextlib
import errno
import socket
from collections import deque
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

from mossar_adapters.abilities import Drops, offered
from mossar_adapters.extras import needed
from mossar_adapters.pipeline import Pipeline
from mossar_adapters.pipeline.counting import counters_of
from mossar_stream import MossarError

if TYPE_CHECKING:
    from prometheus_client.core import Metric

MAX_CLIENTS: Final = 16  # connections; beyond them the oldest is cut off
PATIENCE: Final = 5.0  # s that a client may be silent
_WAITING: Final = 64  # connections that the system keeps until they are accepted
_FRAMES = {
    "frames": "Frames processed",
    "out_of_order": "Frames dropped because they came late or twice",
    "outliers": "Joints that were too fast, or too far off, to be true",
    "held": "Joints that were held because they were missing",
    "gaps": "Frames after a gap",
    "unseen": "Frames without a single joint",
}


class Metrics:
    """Serves `/metrics` in a thread of its own until it is closed.

    Args:
        pipeline: Whose counters are served.
        port: 0 takes a free one.
        host: Where to listen.

    Raises:
        MossarError: If the port cannot be had or the extra `metrics` is not installed.
    """

    def __init__(self, pipeline: Pipeline, port: int, host: str = "127.0.0.1") -> None:
        needed("prometheus_client", "metrics", "--metrics")
        from prometheus_client import CollectorRegistry, ProcessCollector, start_http_server

        self._pipeline = pipeline
        registry = CollectorRegistry()
        registry.register(self)
        ProcessCollector(registry=registry)
        try:
            self._server, self._thread = start_http_server(port, host, registry)
        except OSError as error:
            raise MossarError(f"--metrics {host}:{port}: {_why(error)}") from None
        self._server.socket.listen(_WAITING)  # the library lets 5 wait, and a burst of others would fill that
        self._server.RequestHandlerClass = _bounded(self._server.RequestHandlerClass)
        self.port = int(self._server.server_port)
        self.url = f"http://{host}:{self._server.server_port}/metrics"

    def collect(self) -> "Iterator[Metric]":
        """Yield the present counters; called for every request, in its thread."""
        from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily

        pipeline = self._pipeline
        names = [name for name in pipeline.pool.names if name in pipeline.pool]
        stats = {name: pipeline.pool[name].stats for name in names}
        for field, text in _FRAMES.items():
            family: Any = CounterMetricFamily(f"mossar_{field}", text, labels=["performer"])
            for name in names:
                family.add_metric([name], stats[name][field])
            yield family
        latency = GaugeMetricFamily(
            "mossar_latency_seconds", "From a frame to its events", labels=["performer", "quantile"]
        )
        for performer in list(pipeline.performers.values()):
            for quantile, ms in zip(("0.5", "0.99"), performer.latency.quantiles_ms() or (), strict=False):
                latency.add_metric([performer.name, quantile], ms / 1000)
        yield latency
        yield from self._ends()

    def close(self) -> None:
        """Release the port."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def _ends(self) -> "Iterator[Metric]":
        """Yield the counters of sources and sinks."""
        from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily

        pipeline = self._pipeline
        texts = {
            "malformed": "Messages that could not be used",
            "kernel_drops": "Datagrams that the system dropped",
        }
        sources = [(feed.source.name, counters_of(feed.source)) for feed in pipeline.feeds]
        for field, text in texts.items():
            family = CounterMetricFamily(f"mossar_{field}", text, labels=["source"])
            for name, counted in sources:
                family.add_metric([name], counted.get(field, 0))
            yield family
        dropped = CounterMetricFamily(
            "mossar_dropped", "Frames or events that queues had no room for", labels=["where"]
        )
        for (name, _), count in zip(sources, pipeline.inbox.dropped, strict=True):
            dropped.add_metric([name], count)
        for outlet in list(pipeline.outlets):
            dropping = offered(outlet.sink, Drops)
            lost = outlet.dropped + (0 if dropping is None else dropping.dropped)
            dropped.add_metric([outlet.sink.name], lost)
        yield dropped
        yield GaugeMetricFamily(
            "mossar_outputs_failed", "Sinks that get no more events", len(pipeline.outcome.dead_sinks)
        )


def _bounded(handler: Any) -> Any:
    """Return a handler of requests that idle clients, however many connect, do not keep from others."""
    connections: deque[socket.socket] = deque()  # the oldest first

    class Bounded(handler):  # type: ignore[misc]  # the class is the library's
        timeout = PATIENCE

        def setup(self) -> None:
            super().setup()
            connections.append(self.connection)
            if len(connections) > MAX_CLIENTS:
                with contextlib.suppress(OSError, IndexError):  # another thread was quicker
                    # Its thread reads the end, and closes it.
                    connections.popleft().shutdown(socket.SHUT_RDWR)

        def handle(self) -> None:
            with contextlib.suppress(OSError):  # clients that are too slow, or have left, are not logged
                super().handle()

        def finish(self) -> None:
            with contextlib.suppress(ValueError):  # it was cut off
                connections.remove(self.connection)
            with contextlib.suppress(OSError):
                super().finish()

    return Bounded


def _why(error: OSError) -> str:
    if error.errno == errno.EADDRINUSE:
        return "the port is in use; close the program that has it, or take another port"
    return f"cannot serve: {error.strerror or error}"
