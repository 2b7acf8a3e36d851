"""Admission: whose datagrams are read. The first step from a wire to the pipeline.

It refuses hosts that the user did not allow, and most messages of senders without any valid one, to leave room for
other senders.
"""

from collections.abc import Sequence
from ipaddress import IPv4Network, IPv6Address, IPv6Network, ip_address, ip_network

from mossar_adapters.address import Address
from mossar_adapters.live import Counters
from mossar_adapters.newest import Newest

PATIENCE = 256  # malformed datagrams in a row
_TRIAL = 32  # of a nuisance's datagrams, one in so many is read: it may mend its ways
_MOST = 1024  # senders of rubbish remembered
_MOST_HOSTS = 64  # named when the source explains its silence


class Admission:
    """Decides on each datagram by its sender.

    Args:
        address: Its option `allow` lists numbers and networks: `192.168.0.7,10.0.0.0/8`; without it all are allowed.
        counters: The source's; they count refused messages.

    Raises:
        SettingsError: If one of the numbers is no IP number.
    """

    def __init__(self, address: Address, counters: Counters) -> None:
        self.hosts: dict[str, int] = {}  # datagrams of the first hosts that were heard
        self._allowed = AllowList(address)
        self._nuisances = Nuisances()
        self._counters = counters

    def admits(self, host: str, port: int) -> bool:
        """Count a datagram and return whether to read it."""
        self._counters.received += 1
        if not self._allowed.allows(host):
            self._counters.ignored += 1
            return False
        if host in self.hosts or len(self.hosts) < _MOST_HOSTS:
            self.hosts[host] = self.hosts.get(host, 0) + 1
        if self._nuisances.skips((host, port)):
            self._counters.malformed += 1
            return False
        return True

    def judge(self, host: str, port: int, *, sound: bool) -> None:
        """Note whether an admitted datagram held something that could be used."""
        self._nuisances.judge((host, port), sound=sound)


class AllowList:
    """Addresses whose datagrams are accepted.

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

    def allows(self, host: str) -> bool:
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


class Nuisances:
    """Remembers the senders of invalid data.

    Example:
        >>> nuisances = Nuisances()
        >>> for _ in range(PATIENCE):
        ...     nuisances.judge(("10.0.0.7", 9000), sound=False)
        >>> [nuisances.skips(("10.0.0.7", 9000)) for _ in range(_TRIAL)].count(False)
        1
    """

    def __init__(self) -> None:
        # Malformed datagrams in a row, by host and port.
        self._rubbish: Newest[tuple[str, int], int] = Newest(_MOST)

    def skips(self, sender: tuple[str, int]) -> bool:
        """Return whether a datagram need not be read."""
        count = self._rubbish.get(sender, 0)
        if count < PATIENCE:
            return False
        self._rubbish[sender] = count + 1
        return count % _TRIAL != 0

    def judge(self, sender: tuple[str, int], *, sound: bool) -> None:
        """Note whether a datagram could be used."""
        if sound:
            self._rubbish.pop(sender, None)
            return
        self._rubbish[sender] = self._rubbish.get(sender, 0) + 1
