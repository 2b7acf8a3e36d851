import threading
import time

from mossar_adapters.pipeline.outlet import Outlet, Parcel
from mossar_stream import StreamEvent


def events(take):
    return Parcel([StreamEvent(performer="p1", event="started", take=take)])


class Slow:
    """A sink that takes nothing until it is let."""

    name = "slow"

    def __init__(self):
        self.let = threading.Event()
        self.takes = []

    def announce(self, meta):
        pass

    def send(self, events):
        self.let.wait(5)
        self.takes += [event.take for event in events]

    def close(self):
        pass


def test_a_sink_that_takes_nothing_does_not_stall_a_live_stream():
    sink = Slow()
    outlet = Outlet(sink, waits=False, capacity=10)
    outlet.start()
    start = time.monotonic()
    for take in range(1000):
        outlet.put(events(take))
    assert time.monotonic() - start < 1
    assert outlet.dropped >= 985
    sink.let.set()
    outlet.close()
    assert sink.takes[-10:] == list(range(990, 1000))


def test_a_slow_sink_of_a_recording_gets_everything():
    sink = Slow()
    outlet = Outlet(sink, waits=True, capacity=3)
    outlet.start()
    threading.Timer(0.05, sink.let.set).start()
    for take in range(50):
        outlet.put(events(take))
    outlet.close()
    assert sink.takes == list(range(50))
    assert outlet.dropped == 0


def test_waiting_for_room_ends_when_the_program_is_to_end():
    outlet = Outlet(Slow(), waits=True, capacity=1, gives_up=lambda: True)
    outlet.start()
    start = time.monotonic()
    for take in range(5):
        outlet.put(events(take))
    assert time.monotonic() - start < 1


def test_a_sink_that_fails_is_left_alone_afterwards():
    class Broken(Slow):
        def send(self, events):
            raise OSError(f"no space left for {len(events)} events")

    outlet = Outlet(Broken(), waits=True, capacity=2)
    outlet.start()
    for take in range(10):
        outlet.put(events(take))
    assert outlet.drain(1) is False
    assert str(outlet.error) == "no space left for 1 events"


class Prompt(Slow):
    """A sink that never waits, and knows who called it."""

    prompt = True

    def __init__(self):
        super().__init__()
        self.threads = []
        self.quiet = threading.Event()

    def send(self, events):
        self.threads.append(threading.current_thread())
        self.takes += [event.take for event in events]
        if not events:
            self.quiet.set()


def test_a_prompt_sink_is_fed_at_once_and_looked_after_in_quiet_times(monkeypatch):
    monkeypatch.setattr("mossar_adapters.pipeline.outlet._QUIET", 0.01)
    sink = Prompt()
    outlet = Outlet(sink, waits=False)
    outlet.start()
    assert sink.quiet.wait(5)
    for take in range(50):
        outlet.put(events(take))
        time.sleep(0.001)
    outlet.close()
    assert sink.takes == list(range(50))
    assert threading.current_thread() in sink.threads


def test_a_prompt_sink_that_fails_is_left_alone_afterwards():
    class Broken(Prompt):
        def send(self, events):
            raise OSError(f"no route for {len(events)} events")

    outlet = Outlet(Broken(), waits=False)
    outlet.start()
    outlet.put(events(0))
    outlet.put(events(1))
    assert str(outlet.error) == "no route for 1 events"
    outlet.close()


def test_delivery_is_reported_with_the_time_of_arrival():
    delivered = []
    sink = Slow()
    sink.let.set()
    outlet = Outlet(sink, waits=True, delivered=delivered.append)
    outlet.start()
    outlet.put(Parcel(events(0).item, arrived_at=5.0))
    assert outlet.drain(1)
    assert [parcel.arrived_at for parcel in delivered] == [5.0]
    outlet.close()


def test_what_waits_for_a_slow_reader_is_not_lost_at_the_end(monkeypatch):
    monkeypatch.setattr("mossar_adapters.pipeline.outlet.PATIENCE", 0.01)
    sink = Slow()
    outlet = Outlet(sink, waits=True)
    outlet.start()
    for take in range(5):
        outlet.put(events(take))
    threading.Timer(0.3, sink.let.set).start()
    outlet.close()
    assert sink.takes == [0, 1, 2, 3, 4]
