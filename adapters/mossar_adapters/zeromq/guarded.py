"""Guarded: a ZeroMQ context that lets in only whose keys it knows."""

from pathlib import Path

import zmq
from zmq.auth.thread import ThreadAuthenticator


class GuardedContext(zmq.Context[zmq.Socket[bytes]]):
    """A context whose bound CURVE sockets may ask for the keys of clients."""

    _guard: ThreadAuthenticator | None = None

    def admit(self, folder: Path) -> None:
        """Let in only those whose public keys (.key) are in a folder; to be called before a socket is bound."""
        self._guard = ThreadAuthenticator(self)
        self._guard.start()
        self._guard.configure_curve(domain="*", location=str(folder))

    def term(self) -> None:
        """Stop letting in, and terminate."""
        guard, self._guard = self._guard, None
        if guard is not None:
            guard.stop()
        super().term()
