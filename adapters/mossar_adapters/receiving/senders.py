"""Senders: names for performers, one set per sender.

Protocols without performer ids have one performer per sender: `p1`, `p2` and so on, in the order in which they are
heard. With ids, the first sender's performers have plain names, those of others carry the sender's address. A sender
that restarts, or that opens a socket for every message, shows up with a new port and keeps its name. Two programs on
one computer are distinguished at once if the first has kept its port and has not paused. Otherwise the second port
waits: the first one is heard again if there are two programs, and is silent, or followed by more ports, if there is one.
"""

from typing import Final

from mossar_adapters.newest import Newest
from mossar_adapters.receiving.names import distinct_name

MAX_SENDERS = 64
_MAX_NAMES = 4096
_REMEMBERED = 16  # earlier ports of a host
_STEADY = 32  # datagrams of one port: it is not changed for each
_HOPS = 8  # new ports in a row: there is one for each message
_PAUSE = 0.5  # s; no program ends and starts again as quickly
WAIT: Final = 0.15  # s, several frames; a first port that is silent for so long has a successor


class Senders:
    """Names the performers of several senders.

    Args:
        base: The user's name of the performer, or None.
    """

    def __init__(self, base: str | None = None) -> None:
        self._base = base
        self._hosts: Newest[str, _Host] = Newest(MAX_SENDERS)
        self._names: dict[tuple[str, str], str] = {}  # by suffix and person
        self._latest: tuple[str, int] | None = None  # host and port that sent the latest datagram
        self._suffix = ""  # theirs
        self._first: str | None = None  # host whose performers have plain names

    def suffix(self, host: str, port: int, now: float, until: float | None = None) -> str | None:
        """Return the suffix that distinguishes this sender's performers; empty for the first sender.

        None: a new port, of which the next datagrams of the host show whether it is another program's.

        Args:
            host: Of the sender.
            port: The same.
            now: Time of its arrival, s.
            until: A later time until which nothing else came from the host, s.
        """
        if self._latest != (host, port):
            suffix = self._find(host, port, now, until or now)
            if suffix is None:
                self._latest = None
                return None
            self._latest, self._suffix = (host, port), suffix
        self._hosts[host].heard(port, now)
        return self._suffix

    def _find(self, host: str, port: int, now: float, until: float) -> str | None:
        known = self._hosts.get(host)
        if known is None:
            known = self._hosts[host] = _Host(port)
            self._first = self._first or host
        separate = known.separate(port, now, until)
        if separate is None:
            return None
        if host == self._first:
            return f"{host}:{port}" if separate else ""
        return f"{host}:{port}" if separate else host

    def name(self, suffix: str, person: str = "") -> str:
        """Return a performer's name.

        Args:
            suffix: The sender's, see `suffix`.
            person: The id that the protocol gives; empty if it has none. The first one's does not follow a
                name that the user gave.
        """
        name = self._names.get((suffix, person))
        if name is None:
            if len(self._names) == _MAX_NAMES:
                self._names.clear()
            name = self._names[suffix, person] = self._make(suffix, person)
        return name

    def _make(self, suffix: str, person: str) -> str:
        if self._base is not None:
            parts = [self._base, "" if person in {"1", "p1"} else person, suffix]
        elif person:
            parts = [f"p{person}" if person.isdecimal() else person, suffix]
        else:
            return self._numbered(suffix)
        return distinct_name("_".join(part for part in parts if part))

    def _numbered(self, suffix: str) -> str:
        """Return the name of the only performer of a sender: `p1` of the first one."""
        number = 1 if not suffix else 2
        taken = set(self._names.values())
        while f"p{number}" in taken:
            number += 1
        return f"p{number}"


class _Host:
    """The ports one host sends from."""

    def __init__(self, port: int) -> None:
        self._main = port  # the one with the plain name
        self._former: Newest[int, None] = Newest(_REMEMBERED)
        self._others: set[int] = set()
        self._unclear: list[int] = []  # new ports since the main one was heard
        self._hops = False  # whether there is a new port for each message
        self._count = 0  # datagrams of the main port
        self._heard = float("-inf")  # s, when the latest of them came

    def heard(self, port: int, now: float) -> None:
        """Note a datagram, which came at `now`, s."""
        if port == self._main:
            self._count += 1
            self._heard = now

    def separate(self, port: int, now: float, until: float) -> bool | None:
        """Return whether the port belongs to another program than the one with the plain name; None if it is unclear.

        Args:
            port: Of a datagram.
            now: Time of arrival, s.
            until: When nothing else had come, s.
        """
        if port == self._main:
            for other in self._unclear:
                self._add(other)
            self._unclear.clear()
            return False
        if port in self._others:
            return True
        if self._count >= _STEADY and now - self._heard < _PAUSE:
            self._add(port)
            return True
        if port in self._former:  # two programs take turns: the older one keeps the name
            self._add(self._main)
            del self._former[port]
        elif until - self._heard < WAIT and not self._hops:
            if port not in self._unclear:
                self._unclear.append(port)
            if len(self._unclear) < _HOPS:
                return None
            self._hops = True
            self._former[self._main] = None
        else:
            self._former[self._main] = None
        self._main, self._count = port, 0
        self._unclear.clear()
        return False

    def _add(self, port: int) -> None:
        """Note a port of another program."""
        if len(self._others) == MAX_SENDERS:
            self._others.clear()
        self._others.add(port)
