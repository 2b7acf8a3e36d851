"""Senders of nothing but rubbish: most of what they send is thrown away unread, so that others are heard."""

PATIENCE = 256  # malformed datagrams in a row
_TRIAL = 32  # of a nuisance's datagrams, one in so many is read: it may mend its ways
_MOST = 1024  # senders remembered


class Nuisances:
    """Remembers who sends rubbish.

    Example:
        >>> nuisances = Nuisances()
        >>> for _ in range(PATIENCE):
        ...     nuisances.judge(("10.0.0.7", 9000), sound=False)
        >>> [nuisances.skips(("10.0.0.7", 9000)) for _ in range(_TRIAL)].count(False)
        1
    """

    def __init__(self) -> None:
        self._rubbish: dict[tuple[str, int], int] = {}  # malformed datagrams in a row, by host and port

    def skips(self, sender: tuple[str, int]) -> bool:
        """Return whether a datagram need not be read."""
        count = self._rubbish.get(sender, 0)
        if count < PATIENCE:
            return False
        self._rubbish[sender] = count + 1
        return count % _TRIAL != 0

    def judge(self, sender: tuple[str, int], *, sound: bool) -> None:
        """Take note of whether a datagram could be used."""
        if sound:
            self._rubbish.pop(sender, None)
            return
        count = self._rubbish.pop(sender, 0)
        if len(self._rubbish) == _MOST:
            del self._rubbish[next(iter(self._rubbish))]
        self._rubbish[sender] = count + 1
