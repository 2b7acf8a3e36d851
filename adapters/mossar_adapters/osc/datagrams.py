"""A UDP socket that keeps up: a large buffer, whole reads, true counts of dropped datagrams.

On Linux the kernel reports its drops and the arrival time with each datagram; elsewhere the drops stay 0 and
the time of reading is taken.
"""

import errno
import selectors
import socket
import struct
import sys
import time
from typing import Any, NamedTuple

import msgspec

from mossar_adapters.address import Address
from mossar_stream import MossarError

MAX_DATAGRAM = 65_535  # bytes
WANTED_BUFFER = 4 << 20  # bytes; the usual default holds a tenth of a second of single-joint messages
DRAIN = 512  # datagrams read before the frames in them are handed on
_TOGETHER = 4 << 20  # bytes of them
_RXQ_OVFL, _TIMESTAMPNS = 40, 35  # Linux's SO_RXQ_OVFL and SO_TIMESTAMPNS, which the socket module lacks
_OLDEST = 60.0  # s by which a datagram may be older than the moment when nothing waited
_LOOKS, _BRIEF = 4, 2e-5  # looks at two clocks at most, and s between them that will do
_LINUX = sys.platform == "linux"
_drops, _moment = struct.Struct("=I"), struct.Struct("=qq")  # of datagrams; s and ns since 1970


class Datagram(msgspec.Struct, frozen=True):
    """A datagram: the bytes, the sender's host and port, and the time of arrival (s since the socket opened)."""

    data: bytes
    host: str
    port: int
    arrival: float


class DatagramSocket:
    """Receives UDP datagrams.

    Args:
        address: Where to listen; port 0 takes a free one.

    Raises:
        MossarError: If the host is unknown or the port in use.
    """

    def __init__(self, address: Address) -> None:
        self._socket, self.host, self.port = _bound(address)
        self.buffer = _enlarged(self._socket)  # bytes granted
        self.kernel_drops = 0
        self._tells = _LINUX and _ask(self._socket)  # whether drops and times come with the datagrams
        self._opened = time.monotonic()
        self._emptied = 0.0  # when nothing waited, s since the socket was opened
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._socket, selectors.EVENT_READ)

    @property
    def opened(self) -> float:
        """Time at which our clock was 0, monotonic s."""
        return self._opened

    @property
    def now(self) -> float:
        """Seconds since the socket was opened."""
        return time.monotonic() - self._opened

    def waits(self) -> bool:
        """Return whether something can be read now."""
        return bool(self._selector.select(0))

    def receive(self, seconds: float) -> list[Datagram]:
        """Return the datagrams that have come, at most `DRAIN`; wait for the first of them for `seconds`.

        All are read before any is decoded, so that a stall of this program does not fill the system's buffer.
        """
        found: list[_Read] = []
        emptied = self._emptied
        self._socket.settimeout(seconds)
        size = 0
        while len(found) < DRAIN and size < _TOGETHER:
            try:
                read = self._read()
            except (BlockingIOError, TimeoutError):
                self._emptied = self.now
                break
            except ConnectionError:  # Windows reports here that an earlier answer of ours had no receiver
                continue
            except OSError as error:
                if error.errno == errno.EMSGSIZE:  # Windows again, for too long a datagram
                    continue
                raise
            if not found:
                self._socket.settimeout(0)
            found.append(read)
            size += len(read.data)
        return self._dated(found, emptied)

    def close(self) -> None:
        """Release the port. May be called twice."""
        self._selector.close()
        self._socket.close()

    def _read(self) -> "_Read":
        if not self._tells:
            data, sender = self._socket.recvfrom(MAX_DATAGRAM)
            return _Read(data, sender[0], sender[1], None)
        data, notes, _, sender = self._socket.recvmsg(MAX_DATAGRAM, 128)
        stamp = None
        for _, kind, value in notes:
            if kind == _RXQ_OVFL:
                self.kernel_drops = _drops.unpack_from(value)[0]
            elif kind == _TIMESTAMPNS and len(value) == 16:
                seconds, nanoseconds = _moment.unpack(value)
                stamp = seconds + nanoseconds * 1e-9
        return _Read(data, sender[0], sender[1], stamp)

    def _dated(self, found: "list[_Read]", emptied: float) -> list[Datagram]:
        """Return datagrams with their arrival on our clock; nothing waited at `emptied`, however long ago that is."""
        if not found:
            return []
        now = self.now
        ahead = _ahead() + self._opened
        dated = []
        for data, host, port, stamp in found:
            arrival = now if stamp is None else min(stamp - ahead, now)
            if arrival < emptied - _OLDEST:  # the system's clock was set meanwhile
                arrival = now
            dated.append(Datagram(data, host, port, arrival))
        return dated


class _Read(NamedTuple):
    """A datagram, its sender's host and port, and when it came by the system's clock, s since 1970, or None."""

    data: bytes
    host: str
    port: int
    stamp: float | None


def _ahead() -> float:
    """Return the lead of the system's clock over the monotonic one, s."""
    # A program that is interrupted between two looks would be off by as long, and frames out of order.
    looks = []
    for _ in range(_LOOKS):
        before, system, after = time.monotonic(), time.time(), time.monotonic()
        looks.append((after - before, system - (before + after) / 2))
        if after - before < _BRIEF:
            break
    return min(looks)[1]


def resolve(address: Address, *, passive: bool) -> tuple[socket.AddressFamily, Any]:
    """Return the family and the socket address for UDP.

    Raises:
        MossarError: If the host is unknown.
    """
    flags = socket.AI_PASSIVE if passive else 0
    try:
        found = socket.getaddrinfo(
            address.host or "127.0.0.1", address.required_port(), type=socket.SOCK_DGRAM, flags=flags
        )
    except (OSError, UnicodeError):
        raise MossarError(f"{address.url}: the host {address.host[:80]!r} cannot be found") from None
    family, _, _, _, place = found[0]
    return family, place


def _bound(address: Address) -> tuple[socket.socket, str, int]:
    family, place = resolve(address, passive=True)
    opened = socket.socket(family, socket.SOCK_DGRAM)
    try:
        opened.setblocking(False)
        opened.bind(place)
    except OSError as error:
        opened.close()
        raise MossarError(f"{address.url}: {_why(error, address)}") from None
    name = opened.getsockname()
    return opened, name[0], name[1]


def _why(error: OSError, address: Address) -> str:
    if error.errno == errno.EADDRINUSE:
        return (
            f"UDP port {address.port} is in use; close the program that listens there, or take another port"
        )
    if error.errno == errno.EADDRNOTAVAIL:
        return f"{address.host} is not an address of this computer; 0.0.0.0 listens on all of them"
    if error.errno == errno.EACCES:
        return f"port {address.port} needs administrator rights; take one above 1023"
    return f"cannot listen: {error.strerror or error}"


def _enlarged(opened: socket.socket) -> int:
    """Ask for a large receive buffer and return the bytes granted."""
    for size in (WANTED_BUFFER, WANTED_BUFFER // 4):
        try:
            opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, size)
            break
        except OSError:  # macOS refuses a size above its limit instead of granting less
            continue
    granted = opened.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
    return granted // 2 if _LINUX else granted  # Linux reports twice the granted size


def _ask(opened: socket.socket) -> bool:
    try:
        opened.setsockopt(socket.SOL_SOCKET, _RXQ_OVFL, 1)
        opened.setsockopt(socket.SOL_SOCKET, _TIMESTAMPNS, 1)
    except OSError:
        return False
    return True
