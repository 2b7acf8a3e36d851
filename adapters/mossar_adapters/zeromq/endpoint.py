"""ZeroMQ sockets from URLs: `zmq://HOST:PORT` connects, `zmq+bind://` binds, `ipc:` forms use a local path."""

import errno
import ipaddress
import socket
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import zmq
import zmq.auth

from mossar_adapters.address import Address
from mossar_adapters.regular import check_regular
from mossar_adapters.zeromq.guarded import GuardedContext
from mossar_stream import MossarError

SCHEMES = ("zmq", "zmq+bind", "ipc", "zmq+ipc", "ipc+bind", "zmq+bind+ipc")
CURVE_OPTIONS = {
    "key": "file with our own CURVE key pair (.key_secret)",
    "server_key": "file with the CURVE public key of the side that binds (.key)",
    "clients": "folder with the CURVE public keys (.key) of allowed clients",
}
MAX_MESSAGE = 1 << 17  # bytes; 1024 joints with confidence as JSON take 90 thousand
HANDSHAKE_MS = 3000  # a silent connection holds a descriptor as long
RECONNECT_MS, RECONNECT_MAX_MS = 50, 2000  # back-off between attempts
LINGER_MS = 500  # a sender's last messages may take this long; a dead receiver costs no more


def binds(address: Address) -> bool:
    """Return whether the URL is one to bind."""
    return "bind" in address.scheme


def open_socket(
    context: GuardedContext,
    kind: int,
    address: Address,
    options: Mapping[int, int | bytes],
) -> zmq.Socket[bytes]:
    """Return a socket that is bound or connecting.

    Args:
        context: Its context.
        kind: `zmq.SUB`, `zmq.XPUB`, `zmq.REP`.
        address: Address of the socket.
        options: Socket options; queue lengths only count if they are set before.

    Raises:
        MossarError: If the host is unknown, the port in use, or a key file unreadable.
    """
    endpoint = _endpoint(address)
    opened = context.socket(kind)
    opened.setsockopt(zmq.LINGER, 0 if kind == zmq.SUB else LINGER_MS)
    opened.setsockopt(zmq.MAXMSGSIZE, MAX_MESSAGE)
    opened.setsockopt(zmq.HANDSHAKE_IVL, HANDSHAKE_MS)
    opened.setsockopt(zmq.RECONNECT_IVL, RECONNECT_MS)
    opened.setsockopt(zmq.RECONNECT_IVL_MAX, RECONNECT_MAX_MS)
    for name, value in options.items():
        opened.setsockopt(name, value)
    try:
        _set_keys(opened, address)
        _admit(context, address)
        if binds(address):
            opened.bind(endpoint)
        else:
            opened.connect(endpoint)
    except zmq.ZMQError as error:
        opened.close(0)
        raise MossarError(f"{address.url}: {_why(error, address)}") from None
    except MossarError:
        opened.close(0)
        raise
    return opened


def bound_at(opened: zmq.Socket[bytes]) -> str:
    """Return the endpoint that a bound socket got, with its real port."""
    last: Any = opened.getsockopt(zmq.LAST_ENDPOINT)
    return bytes(last).rstrip(b"\0").decode("utf-8", "replace")


def can_read(opened: zmq.Socket[bytes]) -> bool:
    """Return whether a message waits; asking costs half as much as a failed attempt."""
    state: Any = opened.get(zmq.EVENTS)
    return bool(state & zmq.POLLIN)


def _endpoint(address: Address) -> str:
    if "ipc" in address.scheme:
        if not zmq.has("ipc"):
            raise address.error("this system has no local sockets for ZeroMQ; use zmq://127.0.0.1:5556")
        path = address.host + address.path
        if not path or address.port is not None:
            raise address.error(f"an ipc address holds a path: {address.scheme}:///tmp/mossar")
        return f"ipc://{path}"
    if address.path not in {"", "/"}:
        raise address.error(f"there is no path in it: {address.scheme}://HOST:PORT")
    port = address.required_port()
    if binds(address) and address.host in {"*", "0.0.0.0"}:  # noqa: S104 - the user wrote it
        return f"tcp://*:{port}"
    number = _resolved(address)
    return f"tcp://[{number}]:{port}" if ":" in number else f"tcp://{number}:{port}"


def _resolved(address: Address) -> str:
    """Return the host as a number; ZeroMQ itself would try an unknown host for ever, in silence."""
    host = address.host or "127.0.0.1"
    try:
        found = socket.getaddrinfo(host, address.port, type=socket.SOCK_STREAM)
    except (OSError, UnicodeError):
        raise MossarError(f"{address.url}: the host {host[:80]!r} cannot be found") from None
    numbers = [str(place[0]) for _, _, _, _, place in found]
    return next((n for n in numbers if ipaddress.ip_address(n.partition("%")[0]).version == 4), numbers[0])


def _set_keys(opened: zmq.Socket[bytes], address: Address) -> None:
    if "%" in address.host or ":" in address.host:
        opened.setsockopt(zmq.IPV6, 1)
    own, server = address.options.get("key"), address.options.get("server_key")
    if own is None and server is None:
        return
    if not zmq.has("curve"):
        raise address.error("this ZeroMQ was built without CURVE")
    if own is None or (server is None) != binds(address):
        raise address.error("CURVE needs key= on both sides, and server_key= on the side that connects")
    public, secret = _key(address, own, secret=True)
    opened.curve_publickey, opened.curve_secretkey = public, secret
    if server is None:
        opened.curve_server = True
    else:
        opened.curve_serverkey = _key(address, server, secret=False)[0]


def _admit(context: GuardedContext, address: Address) -> None:
    clients = address.options.get("clients")
    if clients is None:
        return
    if not binds(address) or "key" not in address.options:
        raise address.error("clients= goes with key= on the side that binds")
    try:
        keys = [zmq.auth.load_certificate(file)[0] for file in Path(clients).glob("*.key")]
    except (OSError, ValueError, UnicodeError) as error:
        raise address.error(f"{clients}: a key cannot be read: {error}") from None
    if not keys:
        raise address.error(f"{clients} is no folder with public keys (.key)")
    context.admit(Path(clients))


def _key(address: Address, path: str, *, secret: bool) -> tuple[bytes, bytes]:
    try:
        check_regular(Path(path))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            public, private = zmq.auth.load_certificate(path)
    except (OSError, ValueError, UnicodeError):
        raise address.error(
            f"{path} is no readable CURVE key file (zmq.auth.create_certificates makes them)"
        ) from None
    if secret and private is None:
        raise address.error(f"{path} holds no secret key; name the .key_secret file")
    return public, private or b""


def _why(error: zmq.ZMQError, address: Address) -> str:
    if error.errno == zmq.EADDRINUSE:
        return f"port {address.port} is in use; close the program that has it, or take another port"
    if error.errno in {zmq.EADDRNOTAVAIL, errno.ENODEV}:
        return f"{address.host} is not an address of this computer"
    if error.errno == errno.EACCES:
        return "no permission to open it"
    return f"cannot be opened: {error.strerror or error}"
