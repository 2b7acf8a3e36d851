"""Player: a thread that ends notes in time and keeps the beat of the MIDI clock."""

import heapq
import threading
import time

from mossar_adapters.midi.ports import Port

CLOCK, START, STOP = b"\xf8", b"\xfa", b"\xfc"
PULSES = 24  # of the clock, a quarter note
LATE = 0.25  # s; pulses missed for longer, as when the computer slept, are not made up for


class Player:
    """Plays notes and the clock.

    Args:
        port: Where messages go.

    Attributes:
        dropped: Messages that the port did not accept.
        error: The error that ended the port.
    """

    def __init__(self, port: Port) -> None:
        self.dropped = 0
        self.error: Exception | None = None
        self._port = port
        self._endings: list[tuple[float, bytes]] = []  # heap of when, monotonic s, and a message
        self._held: set[bytes] = set()  # messages that end the notes that are held
        self._pulse = 0.0  # s between two of the clock; 0 while it stands
        self._next = 0.0  # monotonic s, of the next one
        self._until = 0.0  # monotonic s, when the clock stops unless it is prolonged
        self._closed = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="midi", daemon=True)
        self._thread.start()

    def note(self, channel: int, note: int, velocity: int, seconds: float) -> None:
        """Begin a note, which ends by itself."""
        with self._changed:
            self._write(bytes((0x90 | channel, note, velocity)))
            ending = bytes((0x80 | channel, note, 0))
            heapq.heappush(self._endings, (time.monotonic() + seconds, ending))
            self._changed.notify()

    def hold(self, channel: int, note: int, velocity: int) -> None:
        """Begin a note that sounds until `release` or `close`."""
        with self._changed:
            self._write(bytes((0x90 | channel, note, velocity)))
            self._held.add(bytes((0x80 | channel, note, 0)))

    def release(self, channel: int, note: int) -> None:
        """End a note that is held; others are left alone."""
        ending = bytes((0x80 | channel, note, 0))
        with self._changed:
            if ending in self._held:
                self._held.remove(ending)
                self._write(ending)

    def control(self, channel: int, controller: int, value: int) -> None:
        """Set a controller, 0 to 127."""
        with self._changed:
            self._write(bytes((0xB0 | channel, controller, value)))

    def beat(self, quarter: float, lasting: float) -> None:
        """Keep the clock at a tempo; its first pulse comes with a start.

        Args:
            quarter: Length of a quarter note, s.
            lasting: After which the clock stops, s.
        """
        with self._changed:
            now = time.monotonic()
            if not self._pulse:
                self._write(START)
                self._next = now
            self._pulse, self._until = quarter / PULSES, now + lasting
            self._next = min(self._next, now + self._pulse)
            self._changed.notify()

    def rest(self) -> None:
        """Stop the clock."""
        with self._changed:
            self._stop()

    def close(self) -> None:
        """End all notes and stop the clock. May be called twice."""
        with self._changed:
            if not self._closed:
                self._closed = True
                self._stop()
                while self._endings:
                    self._write(heapq.heappop(self._endings)[1])
                for ending in sorted(self._held):
                    self._write(ending)
                self._held.clear()
            self._changed.notify()
        self._thread.join()

    def _run(self) -> None:
        with self._changed:
            while not self._closed and self.error is None:
                due = self._play(time.monotonic())
                self._changed.wait(None if due is None else max(0.0, due - time.monotonic()))

    def _play(self, now: float) -> float | None:
        """Send the messages that are due; return the time of the next one."""
        while self._endings and self._endings[0][0] <= now:
            self._write(heapq.heappop(self._endings)[1])
        if self._pulse and now >= self._until:
            self._stop()
        if self._pulse and now - self._next > LATE:
            self._next = now
        while self._pulse and self._next <= now:
            self._write(CLOCK)
            self._next += self._pulse
        times = [self._endings[0][0]] if self._endings else []
        times += [min(self._next, self._until)] if self._pulse else []
        return min(times, default=None)

    def _stop(self) -> None:
        if self._pulse:
            self._pulse = 0.0
            self._write(STOP)

    def _write(self, message: bytes) -> None:
        if self.error is not None:
            return
        try:
            self.dropped += not self._port.write(message)
        except Exception as error:  # noqa: BLE001 - the sink reports it, not this thread
            self.error = error
