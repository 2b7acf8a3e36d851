"""Targets of MIDI messages: a port of this computer, or a file, pipe or device that takes them as bytes."""

import contextlib
import errno
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol

from mossar_adapters.address import Address
from mossar_adapters.extras import needed
from mossar_adapters.files.output import OutputFile
from mossar_stream import MossarError

EXTRA = "midi"
_STANDARD_ERROR = 2


class Port(Protocol):
    """Takes messages as bytes."""

    def write(self, message: bytes) -> bool:
        """Hand one message over without waiting; return whether it was taken."""

    def close(self) -> None:
        """Release it. May be called twice."""


def open_port(address: Address, *, replace: bool) -> Port:
    """Open the target of a URL: a path, the port `?port=`, otherwise a virtual port `?name=` that programs find.

    Raises:
        MossarError: If it cannot be had.
    """
    if address.path:
        return _opened_path(address, replace=replace)
    return SystemPort(address)


class SystemPort:
    """A port of the system's MIDI.

    Raises:
        MossarError: If the system has no MIDI, no such port, or no virtual ports.
    """

    def __init__(self, address: Address) -> None:
        needed("mido", EXTRA, address.url)
        needed("rtmidi", EXTRA, address.url)
        import mido
        import rtmidi

        self._message = mido.Message
        try:
            with _without_words_of_c():
                self._port = _opened_port(address)
        except (OSError, RuntimeError, rtmidi.RtMidiError) as error:
            raise address.error(
                f"no MIDI port: {str(error).strip() or type(error).__name__}; ?port=NAME takes one that is there "
                "(Windows has no virtual ports), midi:PATH writes the bytes to a file or device"
            ) from None

    def write(self, message: bytes) -> bool:
        """Send a message."""
        self._port.send(self._message.from_bytes(message))
        return True

    def close(self) -> None:
        """Close the port. May be called twice."""
        self._port.close()


def _opened_port(address: Address) -> Any:
    """Return a virtual port, or the one that is wanted."""
    import mido

    wanted = address.options.get("port")
    if wanted is None:
        return mido.open_output(address.options.get("name", "mossar"), virtual=True)
    names = mido.get_output_names()
    found = [name for name in names if wanted.lower() in name.lower()]
    if not found:
        raise _no_port(address, wanted, names)
    return mido.open_output(found[0])


@contextlib.contextmanager
def _without_words_of_c() -> Iterator[None]:
    """Keep the output of the system's libraries from standard error; their errors are raised as well."""
    try:
        kept = os.dup(_STANDARD_ERROR)
    except OSError:  # it is closed
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, _STANDARD_ERROR)
        yield
    finally:
        os.dup2(kept, _STANDARD_ERROR)
        os.close(kept)
        os.close(nowhere)


def _no_port(address: Address, wanted: str, names: list[str]) -> MossarError:
    return address.error(f"no MIDI port is called {wanted[:40]!r}; there are {', '.join(names) or 'none'}")


def _opened_path(address: Address, *, replace: bool) -> Port:
    if address.path.lower().endswith((".mid", ".midi")):
        raise address.error("this writes the bytes of a live stream, which a .mid file does not hold")
    path = Path(address.path)
    if path.exists() and not path.is_file() and not path.is_dir():
        return DevicePort(address)
    return FilePort(address, replace=replace)


class FilePort:
    """A file."""

    def __init__(self, address: Address, *, replace: bool) -> None:
        self._file = OutputFile(address.path, replace=replace)

    def write(self, message: bytes) -> bool:
        """Append a message."""
        self._file.write(message)
        self._file.flush()
        return True

    def close(self) -> None:
        """Close the file. May be called twice."""
        self._file.close()


class DevicePort:
    """A device or pipe, as /dev/snd/midiC1D0; messages that it cannot take at once are dropped."""

    def __init__(self, address: Address) -> None:
        self._descriptor = -1
        try:
            self._descriptor = os.open(address.path, os.O_WRONLY | getattr(os, "O_NONBLOCK", 0))
        except OSError as error:
            reason = "nobody reads it" if error.errno == errno.ENXIO else error.strerror or str(error)
            raise address.error(f"cannot be written: {reason}") from None

    def write(self, message: bytes) -> bool:
        """Send a message; a device with no room for it takes none of it."""
        try:
            os.write(self._descriptor, message)
        except BlockingIOError:
            return False
        return True

    def close(self) -> None:
        """Close the device. May be called twice."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1
