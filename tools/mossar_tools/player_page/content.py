"""Content: the page's own files, its colours, and its permissions."""

from collections.abc import Callable, Iterable, Mapping
from importlib.resources import files
from typing import Final

import msgspec

from mossar_tools.palette import DARK, LIGHT, Palette

_OWN: Final = ("page.css", "page.js", "stage.js", "eye.js", "icon.svg")
KINDS: Final = {
    ".txt": "text/plain; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".css": "text/css",
    ".js": "text/javascript",
    ".mjs": "text/javascript",
    ".json": "application/json",
    ".svg": "image/svg+xml",
    ".wasm": "application/wasm",
    ".task": "application/octet-stream",
}
Content = Callable[[], bytes]


def own_files() -> Mapping[str, Content]:
    """Return the reader of each of the page's own files, by its path."""
    found: dict[str, Content] = {f"/{name}": files(__package__).joinpath(name).read_bytes for name in _OWN}
    found["/"] = files(__package__).joinpath("page.html").read_bytes
    found["/colours.css"] = colours
    return found


def colours() -> bytes:
    """Return the palette shared with pictures and the dashboard, as variables of a style sheet."""
    light, dark = _variables(LIGHT), _variables(DARK)
    return (
        f":root {{ color-scheme: light; {light} }}\n:root[data-theme=dark] {{ color-scheme: dark; {dark} }}\n"
    ).encode()


def policy(lines: Iterable[str]) -> str:
    """Return the permissions of the page: nothing outside this computer.

    Args:
        lines: URLs that it may connect to, beside its own server.
    """
    return "; ".join(
        (
            "default-src 'none'",
            "script-src 'self' 'wasm-unsafe-eval'",
            "style-src 'self'",
            "img-src 'self'",
            "media-src 'self' blob:",
            " ".join(("connect-src 'self'", *lines)),
            "base-uri 'none'",
            "form-action 'none'",
            "frame-ancestors 'none'",
        )
    )


def _variables(palette: Palette) -> str:
    return " ".join(f"--{name}: {value};" for name, value in msgspec.structs.asdict(palette).items())
