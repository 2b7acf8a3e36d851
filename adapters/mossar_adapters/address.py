"""Source and sink URLs taken apart: scheme, host, port, path, options."""

import ipaddress
import re
from collections.abc import Mapping
from urllib.parse import parse_qsl, unquote, urlsplit

import msgspec

from mossar_stream import SettingsError

_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):")  # two letters or more: C:\take.bvh is a path
_PLACE = re.compile(r"[\w.-]+:\d+")  # of a URL without its slashes
_SHOWN = 80  # characters of a URL in a message


class Address(msgspec.Struct, frozen=True):
    """A URL taken apart.

    Args:
        url: As the user wrote it, for messages.
        scheme: Lower case; `file` for a plain path, `-` for standard input or output.
        host: Host name or IP number without brackets; empty if none was given.
        port: None if none was given.
        path: Path of a file or of an `ipc:` socket.
        options: The part after the question mark.
    """

    url: str
    scheme: str
    host: str = ""
    port: int | None = None
    path: str = ""
    options: dict[str, str] = msgspec.field(default_factory=dict)

    def error(self, problem: str) -> SettingsError:
        """Return an error that names this URL."""
        return SettingsError(f"{self.url[:_SHOWN]}: {problem}")

    def check(self, legal: Mapping[str, str]) -> None:
        """Check the names of the options.

        Args:
            legal: Name of each legal option with its meaning.

        Raises:
            SettingsError: If there is another one; names the legal ones.
        """
        for name in self.options:
            if name not in legal:
                known = ", ".join(legal) or "none"
                raise self.error(f"there is no option {name[:40]!r}; there are: {known}")

    def required_port(self) -> int:
        """Return the port.

        Raises:
            SettingsError: If there is none.
        """
        if self.port is None:
            place = self.path if _PLACE.fullmatch(self.path) else f"{self.host or '127.0.0.1'}:5556"
            raise self.error(f"a port is missing, as in {self.scheme}://{place}")
        return self.port

    def number(self, name: str, low: float, high: float, default: float | None = None) -> float | None:
        """Return the option `name` as a number in low..high.

        Raises:
            SettingsError: If it is none, or out of range.
        """
        text = self.options.get(name)
        if text is None:
            return default
        try:
            value = float(text)
        except ValueError:
            raise self.error(f"option {name} must be a number, not {text[:40]!r}") from None
        if not low <= value <= high:
            raise self.error(f"option {name} must lie in {low:g} to {high:g}, not {text[:40]}")
        return value

    def choice(self, name: str, legal: tuple[str, ...], default: str) -> str:
        """Return the option `name`, one of the legal words.

        Raises:
            SettingsError: If it is another word; names the legal ones.
        """
        text = self.options.get(name, default)
        if text not in legal:
            raise self.error(f"option {name} must be one of {', '.join(legal)}, not {text[:40]!r}")
        return text

    def host_port(self, default_host: str = "127.0.0.1") -> str:
        """Return `host:port` with brackets around IPv6 numbers."""
        host = self.host or default_host
        return f"[{host}]:{self.port}" if ":" in host else f"{host}:{self.port}"


def parse_url(url: str) -> Address:
    """Take a source or sink URL apart.

    Args:
        url: `osc://127.0.0.1:39539?profile=vmc`, `zmq+ipc:///tmp/pose`, `demo:?seed=3`, `-`, or a path.

    Raises:
        SettingsError: If host, port or options cannot be read.

    Example:
        >>> parse_url("osc://[::1]:9000?fps=30").host
        '::1'
    """
    if not url or "\0" in url:
        raise SettingsError("a source or sink is a URL or a path, not an empty one")
    if url == "-":
        return Address(url, "-")
    scheme = _SCHEME.match(url)
    if scheme is None:
        return Address(readable(url), "file", path=url)
    if scheme[1].lower() == "file":
        return Address(readable(url), "file", path=_file_path(url))
    url = readable(url)
    try:
        parts = urlsplit(url)
        host, port = parts.hostname or "", parts.port
    except ValueError as error:
        raise SettingsError(f"{url[:_SHOWN]}: {_reason(str(error))}") from None
    address = Address(url, parts.scheme.lower(), host, port, unquote(parts.path), _options(url, parts.query))
    if parts.username is not None or parts.fragment:
        raise address.error("there is no user name and no # in it")
    return address


def readable(name: str) -> str:
    r"""Return a file name or URL as it may stand in messages, events and snapshots.

    File names of Linux are bytes: those that are no UTF-8, or move the cursor of a terminal, are replaced.

    Example:
        >>> ascii(readable("walk\udcff\x1b[2J.bvh"))
        "'walk\\ufffd\\ufffd[2J.bvh'"
    """
    return "".join(c if c.isprintable() else "\ufffd" for c in name)


def numeric_host(host: str) -> bool:
    """Return whether a host is given as an IP number."""
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True


def _file_path(url: str) -> str:
    path = url[len("file:") :]
    if path.startswith("//"):
        host, slash, rest = path[2:].partition("/")
        if host not in {"", "localhost"}:
            raise SettingsError(f"{url[:_SHOWN]}: files lie on this computer: file:PATH or file:///PATH")
        path = slash + rest
    if not path:
        raise SettingsError(f"{url[:_SHOWN]}: the path is missing: file:PATH")
    path = unquote(path)
    return path[1:] if re.match(r"/[A-Za-z]:[/\\]", path) else path


def _options(url: str, query: str) -> dict[str, str]:
    options: dict[str, str] = {}
    try:
        pairs = parse_qsl(query, keep_blank_values=True, strict_parsing=bool(query), max_num_fields=64)
    except ValueError:
        raise SettingsError(f"{url[:_SHOWN]}: options look like ?name=value&name=value") from None
    for name, value in pairs:
        if name in options:
            raise SettingsError(f"{url[:_SHOWN]}: option {name[:40]} is given twice")
        options[name] = value
    return options


def _reason(error: str) -> str:
    if "port" in error.lower():
        return "the port must be a number, 0 to 65535"
    return f"this is no URL ({error})"
