"""Visitors: the devices that may see the page. This computer may; another device needs a URL that serves once.

The URL holds a key. Its first visitor gets a cookie in exchange, and the key is worthless from then on: to read it over a
shoulder, in a history or in a log is too late. A browser sends the cookie with every request.
"""

import re
import secrets
import socket
from collections.abc import Callable
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from ipaddress import ip_address
from typing import Any

HERE = "127.0.0.1"
_ANYWHERE = {"", "0.0.0.0", "::"}  # noqa: S104 - of users
_OURS = re.compile(r"https?://(127\.0\.0\.1|localhost|\[::1\])(:\d+)?")  # any port: it may be forwarded
_COOKIE = "mossar"
_KEY = "key="
_BYTES = 16  # of a key, and of a session
_MOST = 64  # sessions; the oldest ends
_REFUSED = "The dashboard answers to pages of its own only.\n"
_NEEDS_KEY = "Ask for a new URL of the dashboard: the program prints one, which serves once.\n"


class Visitors:
    """Decides on each request.

    Args:
        host: Where the page is served.
        tell: Called with the next URL as soon as one was used.
    """

    def __init__(self, host: str, tell: Callable[[str], None]) -> None:
        self._host = host
        self._tell = tell
        self._port = 0
        self._key = secrets.token_urlsafe(_BYTES)
        self._sessions: dict[str, None] = {}

    @property
    def admits_others(self) -> bool:
        """Whether other devices reach the page at all."""
        return self._host in _ANYWHERE or not is_loopback(self._host)

    def invitation(self, port: int) -> str:
        """Return the URL that serves once, for a page at this port."""
        self._port = port
        host = _own_address() if self._host in _ANYWHERE else self._host
        return f"http://{f'[{host}]' if ':' in host else host}:{port}/?{_KEY}{self._key}"

    def refusal(self, connection: Any, request: Any) -> Any | None:
        """Return an answer that refuses a visitor or admits it by its key; None for admitted ones."""
        origin, host = request.headers.get("Origin"), request.headers.get("Host", "")
        if is_loopback(connection.remote_address[0]):
            strange = origin is not None and not _OURS.fullmatch(origin)
            return connection.respond(HTTPStatus.FORBIDDEN, _REFUSED) if strange else None
        if origin not in {None, f"http://{host}"}:  # programs that are no browsers send none
            return connection.respond(HTTPStatus.FORBIDDEN, _REFUSED)
        if self._knows(request.headers.get("Cookie", "")):
            return None
        _, _, query = request.path.partition("?")
        if query.startswith(_KEY) and secrets.compare_digest(query[len(_KEY) :].encode(), self._key.encode()):
            return self._let_in(connection)
        return connection.respond(HTTPStatus.FORBIDDEN, _NEEDS_KEY)

    def asks_from_the_page(self, connection: Any, request: Any) -> bool:
        """Return whether an admitted visitor's request comes from the page itself, by the host that its browser names."""
        if not is_loopback(connection.remote_address[0]):
            return True  # other sites have no cookie of ours
        return _OURS.fullmatch(f"http://{request.headers.get('Host', '')}") is not None

    def _knows(self, cookies: str) -> bool:
        try:
            found = SimpleCookie(cookies).get(_COOKIE)
        except CookieError:
            return False
        return found is not None and found.value in self._sessions

    def _let_in(self, connection: Any) -> Any:
        """Exchange the key for a cookie, and make the next key."""
        session = secrets.token_urlsafe(_BYTES)
        self._sessions[session] = None
        if len(self._sessions) > _MOST:
            del self._sessions[next(iter(self._sessions))]
        self._key = secrets.token_urlsafe(_BYTES)
        self._tell(self.invitation(self._port))
        answer = connection.respond(HTTPStatus.SEE_OTHER, "")
        answer.headers["Location"] = "/"
        answer.headers["Set-Cookie"] = f"{_COOKIE}={session}; Path=/; HttpOnly; SameSite=Lax"
        return answer


def is_loopback(host: str) -> bool:
    """Return whether an address is one of this computer that no other device reaches."""
    try:
        number = ip_address(host.partition("%")[0])
    except ValueError:
        return host == "localhost"
    mapped = getattr(number, "ipv4_mapped", None)  # as a socket for both writes IPv4
    return (mapped or number).is_loopback


def _own_address() -> str:
    """Return the address by which other devices of the network reach this computer; nothing is sent."""
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
            asking.connect(("192.0.2.1", 9))
            return str(asking.getsockname()[0])
    except OSError:
        return socket.gethostname()
