"""Owners: a performer's name belongs to the connection that used it first.

A second connection that uses it becomes the next performer: `p2` for a second `p1`, `ann_2` for a second `ann`. It keeps
that name as long as it lasts. If the owner has been silent for two seconds, its connection may be dead without a word,
as after the loss of a wireless network: then the name passes on. New names of a connection are limited, so that one
that invents them does not take the places of others.
"""

import itertools
import logging
from collections import OrderedDict
from typing import Final

import msgspec

from mossar_adapters.receiving.names import distinct_name
from mossar_adapters.receiving.recent import SILENT
from mossar_stream import FrameError

AT_ONCE: Final = 64  # names of a connection
A_SECOND: Final = 8.0  # further names
_MOST: Final = 256  # names that are remembered of a connection
_MOST_LOGGED: Final = 20

_log = logging.getLogger("mossar.source")


class _Owner(msgspec.Struct):
    """The owner of a name."""

    connection: str
    heard: float  # s, when the name was used last


class _Connection(msgspec.Struct):
    """State of a connection."""

    names: OrderedDict[str, str] = msgspec.field(
        default_factory=OrderedDict
    )  # given names, by those that it uses
    left: float = AT_ONCE  # new names that it may use
    looked: float = float("-inf")  # s


class Owners:
    """Gives the performers of several connections names of their own.

    Example:
        >>> owners = Owners()
        >>> owners.name("first", "p1", 0.0), owners.name("second", "p1", 0.1), owners.name("first", "p1", 0.2)
        ('p1', 'p2', 'p1')
        >>> owners.forget("first"), owners.name("third", "p1", 0.3), owners.name("second", "p1", 0.4)
        (['p1'], 'p1', 'p2')
    """

    def __init__(self) -> None:
        self._owners: dict[str, _Owner] = {}  # of each name
        self._connections: dict[str, _Connection] = {}
        self._logged = 0

    def name(self, connection: str, said: str, now: float) -> str:
        """Return the name of a performer.

        Args:
            connection: The connection.
            said: Its name of the performer.
            now: s.

        Raises:
            FrameError: If the connection uses too many new names.
        """
        own = self._connections.setdefault(connection, _Connection())
        given = own.names.get(said)
        owner = None if given is None else self._owners.get(given)
        if given is None or owner is None or owner.connection != connection:
            given = self._new(connection, own, said, now)
            owner = self._owners[given]
        own.names.move_to_end(said)
        owner.heard = now
        return given

    def forget(self, connection: str) -> list[str]:
        """Forget a connection that has ended; return the names that were its own at the end."""
        own = self._connections.pop(connection, _Connection())
        return [name for name in own.names.values() if self._release(name, connection)]

    def _new(self, connection: str, own: _Connection, said: str, now: float) -> str:
        """Give a connection a name that it did not have before."""
        own.left = (
            min(AT_ONCE, own.left + A_SECOND * max(0.0, now - own.looked)) if own.looked <= now else own.left
        )
        own.looked = max(own.looked, now)
        if own.left < 1:
            raise FrameError(
                f"a connection may use {AT_ONCE} names at once and {A_SECOND:g} more a second; {said[:40]} is refused"
            )
        own.left -= 1
        given = self._free(said, now)
        self._log(said, given)
        self._owners[given] = _Owner(connection, now)
        own.names[said] = given
        if len(own.names) > _MOST:
            self._release(own.names.popitem(last=False)[1], connection)
        return given

    def _free(self, said: str, now: float) -> str:
        """Return the name, or the next one, that is free or was not used lately."""
        numbered = said[1:].isdecimal() and said[:1] == "p"
        following = (f"p{n}" if numbered else distinct_name(f"{said}_{n}") for n in itertools.count(2))
        return next(name for name in itertools.chain([said], following) if self._is_free(name, now))

    def _is_free(self, name: str, now: float) -> bool:
        owner = self._owners.get(name)
        return owner is None or now - owner.heard >= SILENT

    def _release(self, name: str, connection: str) -> bool:
        """Let others have a name, if it is the connection's; return whether it is."""
        owner = self._owners.get(name)
        if owner is None or owner.connection != connection:
            return False
        del self._owners[name]
        return True

    def _log(self, said: str, given: str) -> None:
        if given == said and said not in self._owners:
            return
        self._logged += 1
        if self._logged > _MOST_LOGGED:
            return
        if given == said:
            _log.warning("%s is sent by another connection now; the former one is silent", said)
        else:
            _log.warning("a second connection sends %s: it is called %s", said, given)
