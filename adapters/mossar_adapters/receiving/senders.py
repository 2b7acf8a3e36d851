"""Who sends: names for performers, one set per sender.

Protocols without performer ids have one performer per sender. The first sender's performers have plain names,
those of others carry the sender's address. A sender that restarts, or that opens a socket for every message,
shows up with a new port and keeps its name; two programs on one computer are told apart as soon as the first
one is heard again after the second.
"""

from collections import OrderedDict
from collections.abc import Sequence
from ipaddress import IPv4Network, IPv6Address, IPv6Network, ip_address, ip_network

from mossar_adapters.address import Address
from mossar_stream.frames import performer_name

MAX_SENDERS = 64
_MAX_NAMES = 4096
_REMEMBERED = 16  # earlier ports of a host


class Senders:
    """Names the performers of several senders.

    Args:
        base: What the user calls the performer, or None.
    """

    def __init__(self, base: str | None = None) -> None:
        self._base = base
        self._hosts: OrderedDict[str, _Host] = OrderedDict()
        self._names: dict[tuple[str, str], str] = {}  # by suffix and person
        self._latest: tuple[str, int] | None = None  # host and port that sent the latest datagram
        self._suffix = ""  # theirs
        self._first: str | None = None  # host whose performers have plain names

    def suffix(self, host: str, port: int) -> str:
        """Return what tells this sender's performers from those of others; empty for the first sender."""
        if self._latest != (host, port):
            self._latest, self._suffix = (host, port), self._find(host, port)
        return self._suffix

    def _find(self, host: str, port: int) -> str:
        known = self._hosts.get(host)
        if known is None:
            known = self._hosts[host] = _Host(port)
            self._first = self._first or host
            if len(self._hosts) > MAX_SENDERS:
                self._hosts.popitem(last=False)
        separate = known.separate(port)
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
            parts = [suffix or "p1"]
        return performer_name("_".join(part for part in parts if part))


class _Host:
    """The ports one host sends from."""

    def __init__(self, port: int) -> None:
        self._main = port  # the one with the plain name
        self._former: OrderedDict[int, None] = OrderedDict()
        self._others: set[int] = set()

    def separate(self, port: int) -> bool:
        """Return whether the port belongs to another program than the one with the plain name."""
        if port == self._main:
            return False
        if port in self._others:
            return True
        if port in self._former:  # two programs take turns: the older one keeps the name
            if len(self._others) == MAX_SENDERS:
                self._others.clear()
            self._others.add(self._main)
            self._main = port
            del self._former[port]
            return False
        self._former[self._main] = None
        if len(self._former) > _REMEMBERED:
            self._former.popitem(last=False)
        self._main = port
        return False


class AllowList:
    """Addresses whose datagrams are welcome.

    Args:
        address: Its option `allow` lists numbers and networks: `192.168.0.7,10.0.0.0/8`; without it all are.

    Raises:
        SettingsError: If one of them is no IP number.
    """

    def __init__(self, address: Address) -> None:
        self._networks: Sequence[IPv4Network | IPv6Network] = ()
        self._known: dict[str, bool] = {}
        text = address.options.get("allow")
        if text is None:
            return
        try:
            self._networks = [ip_network(part.strip(), strict=False) for part in text.split(",")]
        except ValueError as error:
            raise address.error(f"option allow lists IP numbers or networks: {error}") from None

    def welcome(self, host: str) -> bool:
        """Return whether a host may send."""
        if not self._networks:
            return True
        known = self._known.get(host)
        if known is None:
            number = ip_address(host.partition("%")[0])
            if isinstance(number, IPv6Address) and number.ipv4_mapped:  # as a socket for both writes IPv4
                number = number.ipv4_mapped
            known = any(number in network for network in self._networks)
            if len(self._known) < 4096:
                self._known[host] = known
        return known
