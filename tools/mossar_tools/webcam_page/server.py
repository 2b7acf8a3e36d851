"""The server of the page: a few files of ours and of the maker's, for pages of this computer only."""

import json
import threading
from collections.abc import Callable, Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from pathlib import Path
from typing import Any, Final

from mossar_adapters.maps.codec import to_json
from mossar_adapters.maps.frame_maps import map_of_meta
from mossar_adapters.pose.task import write_task
from mossar_adapters.pose.types import SKELETON
from mossar_adapters.pose.weights import LIBRARY, MODELS, folder, kept, library, weights
from mossar_adapters.source import Meta
from mossar_stream import MossarError
from mossar_tools.console import LOGGER

HOST: Final = "127.0.0.1"
_OWN: Final = ("page.html", "page.css", "page.js")
_KINDS: Final = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css",
    ".js": "text/javascript",
    ".mjs": "text/javascript",
    ".json": "application/json",
    ".wasm": "application/wasm",
    ".task": "application/octet-stream",
}
Content = Callable[[], bytes]


class PageServer:
    """Serves the page at 127.0.0.1 until it is closed.

    Args:
        port: Where; 0 takes a free one.
        poses: Port of the source to which the page sends poses.
        events: Port of the sink from which it receives what was recognised.
        model: To begin with.

    Raises:
        MossarError: If the port cannot be had, or the weights or the maker's library cannot.
    """

    def __init__(self, port: int, poses: int, events: int, model: str) -> None:
        weights(model, LOGGER.info)
        place = library(LOGGER.info)
        models = [name for name in MODELS if kept(name) is not None]
        lines = {"poses": f"ws://{HOST}:{poses}", "events": f"ws://{HOST}:{events}"}
        about = {
            **lines,
            "model": model,
            "models": models,
            "meta": json.loads(to_json(map_of_meta(Meta("p1", SKELETON)))),
        }
        content: dict[str, Content] = {
            f"/{name}": files(__package__).joinpath(name).read_bytes for name in _OWN
        }
        content["/"] = content.pop("/page.html")
        content |= {f"/{file.file}": (place / file.file).read_bytes for file in LIBRARY}
        content |= {f"/{name}.task": _task_of(name) for name in models}
        content["/about.json"] = lambda: json.dumps(about).encode()
        try:
            self._server = ThreadingHTTPServer((HOST, port), _answering(content, _policy(lines)))
        except OSError as error:
            raise MossarError(
                f"the page cannot be served at port {port}: {error.strerror or error}"
            ) from None
        self._server.daemon_threads = True
        self.port = int(self._server.server_address[1])
        self.url = f"http://{HOST}:{self.port}/"
        threading.Thread(target=self._server.serve_forever, name="page", daemon=True).start()

    def close(self) -> None:
        """Release the port."""
        self._server.shutdown()
        self._server.server_close()


def _task_of(model: str) -> Content:
    """Return what makes the bundle of a model, once, and reads it."""

    def read() -> bytes:
        found = weights(model)
        path: Path = folder() / f"pose_{model}.task"
        if not path.exists() or path.stat().st_mtime < found.landmarks.stat().st_mtime:
            write_task(found, path)
        return path.read_bytes()

    return read


def _policy(lines: Mapping[str, str]) -> str:
    """Return what the page may do: nothing outside this computer."""
    return "; ".join(
        (
            "default-src 'none'",
            "script-src 'self' 'wasm-unsafe-eval'",
            "style-src 'self'",
            "img-src 'self'",
            "media-src 'self' blob:",
            f"connect-src 'self' {' '.join(lines.values())}",
            "base-uri 'none'",
            "form-action 'none'",
            "frame-ancestors 'none'",
        )
    )


def _answering(content: Mapping[str, Content], policy: str) -> type[BaseHTTPRequestHandler]:
    """Return what answers requests."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            host = self.headers.get("Host", "").rpartition(":")[0]
            path = self.path.partition("?")[0]
            if host not in {HOST, "localhost"}:  # a name of another site that points here
                self._send(HTTPStatus.FORBIDDEN, b"this page is served to this computer only\n", ".html")
            elif path not in content:
                self._send(HTTPStatus.NOT_FOUND, b"there is no such page\n", ".html")
            else:
                self._send(HTTPStatus.OK, content[path](), Path(path).suffix or ".html")

        def _send(self, status: HTTPStatus, body: bytes, kind: str) -> None:
            self.send_response(status)
            for name, value in (
                ("Content-Type", _KINDS[kind]),
                ("Content-Length", str(len(body))),
                ("Content-Security-Policy", policy),
                ("X-Content-Type-Options", "nosniff"),
                ("Referrer-Policy", "no-referrer"),
                ("Cache-Control", "no-cache"),
            ):
                self.send_header(name, value)
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, format: str, *arguments: Any) -> None:  # noqa: A002 - the library's name
            LOGGER.debug(f"page: {format}", *arguments)

    return Handler
