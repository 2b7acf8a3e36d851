"""A UDP socket that sends without ever waiting."""

import socket

from mossar_adapters.address import Address
from mossar_adapters.osc.datagrams import resolve

_SEND_BUFFER = 1 << 20  # bytes


class DatagramSender:
    """Sends datagrams to one place; datagrams that the system does not take at once are counted.

    Args:
        address: Host and port.

    Raises:
        MossarError: If the host is unknown.
    """

    def __init__(self, address: Address) -> None:
        family, self._place = resolve(address, passive=False)
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        if family == socket.AF_INET:
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        self.dropped = 0

    def send(self, data: bytes) -> bool:
        """Send a datagram and return whether the system took it."""
        try:
            self._socket.sendto(data, self._place)
        except OSError:  # no listener, no route, no room: UDP promises nothing
            self.dropped += 1
            return False
        return True

    def close(self) -> None:
        """Release the socket. May be called twice."""
        self._socket.close()
