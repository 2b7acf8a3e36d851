"""What a live run must survive: partners that die and come back, partners that mean harm."""

import json
import os
import signal
import socket
import sys
import time
from pathlib import Path

import msgspec
import numpy as np
import pytest
import zmq
from websockets.sync.client import connect

from checks.run_process import free_port
from mossar_adapters.osc.encode import bundle, encode

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX systems")


@pytest.fixture
def ports():
    return [free_port(), free_port(socket.SOCK_DGRAM), free_port(), free_port(), free_port()]


@pytest.fixture
def start(process, ports):
    """Start a run that listens to ZeroMQ and OSC and serves ZeroMQ and WebSocket; wait until it is ready."""

    def run(*options):
        zmq_in, osc_in, zmq_out, ws_out, control = ports
        sources = (f"zmq+bind://127.0.0.1:{zmq_in}", f"osc://127.0.0.1:{osc_in}")
        sinks = ("--to", f"zmq+bind://127.0.0.1:{zmq_out}", "--to", f"ws://127.0.0.1:{ws_out}")
        running = process("run", *sources, *sinks, "--control", f"zmq+bind://127.0.0.1:{control}", *options)
        asked(control, {"get": "settings"}, 100)
        return running

    return run


def asked(port, request, seconds=10):
    with zmq.Context.instance().socket(zmq.REQ) as asking:
        asking.setsockopt(zmq.LINGER, 0)
        asking.setsockopt(zmq.RCVTIMEO, int(seconds * 1000))
        asking.connect(f"tcp://127.0.0.1:{port}")
        asking.send(json.dumps(request).encode())
        answer = json.loads(asking.recv())
        assert "value" in answer, answer
        return answer["value"]


def frames_of(performer, count, control):
    """Return the stats of a performer when it has as many frames."""
    deadline = time.monotonic() + 20
    while True:
        stats = asked(control, {"get": "stats"}).get(performer, {})
        if stats.get("frames", 0) >= count or time.monotonic() > deadline:
            return stats
        time.sleep(0.1)


def come_to_rest(control):
    """Wait until nobody's frames have come for 2.5 s: newcomers are refused until somebody has been idle for 2 s."""
    deadline = time.monotonic() + 60  # a busy machine has some of the flood still before it
    before, now = None, {}
    while before != now and time.monotonic() < deadline:
        time.sleep(2.5)
        stats = asked(control, {"get": "stats"}, 60)
        before, now = now, {name: row.get("frames") for name, row in stats.items()}


def subscribed(port):
    socket_ = zmq.Context.instance().socket(zmq.SUB)
    socket_.setsockopt(zmq.SUBSCRIBE, b"mossar.")
    socket_.setsockopt(zmq.RCVTIMEO, 20_000)
    socket_.setsockopt(zmq.LINGER, 0)
    socket_.connect(f"tcp://127.0.0.1:{port}")
    return socket_


def until(receive, wanted):
    """Return what came, up to the first message for which `wanted` is true."""
    found = []
    while not found or not wanted(found[-1]):
        found.append(receive())
    return found


def ended(running):
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=30)
    assert running.returncode == 130, said
    assert b"Traceback" not in said
    return said.decode()


def test_senders_and_receivers_may_be_killed_and_come_back(start, process, ports):
    zmq_in, osc_in, zmq_out, ws_out, _ = ports
    running = start()
    to = ("--to", f"zmq://127.0.0.1:{zmq_in}?wait=20", "--to", f"osc://127.0.0.1:{osc_in}", "--speed", "6")
    for take in range(2):
        sender = process("replay", "demo:?seed=3", *to)
        subscriber = subscribed(zmq_out)
        with connect(f"ws://127.0.0.1:{ws_out}", close_timeout=0.1) as page:

            def confirmed(event, name, take=take):
                status = (event["type"], event.get("performer"), event.get("status"), event.get("take"))
                return status == ("key_frame", name, "confirmed", take)

            for name in ("p1", "p2"):
                until(lambda: json.loads(page.recv(20)), lambda e, name=name: confirmed(e, name))

            def heard(subscriber=subscriber):
                return msgspec.msgpack.decode(subscriber.recv_multipart()[1])

            events = until(heard, lambda e: confirmed(e, "p1"))
            assert any(event["type"] == "meta" for event in events), "also for whoever joins late"
            sender.kill()
            sender.wait()
            until(heard, lambda e: e.get("event") == "ended")
            page.socket.shutdown(socket.SHUT_RDWR)  # no good-bye
        subscriber.close()
    ended(running)


def rubbish():
    random = np.random.default_rng(5)
    good = encode("/joint", "sifff", "head", 1, 0.5, 0.5, 0.5)
    yield from (b"", b"#bundle\0", bundle([good, good])[:-9], b"/" + b"a" * 65_000, b"\xff" * 65_500)
    yield from (random.bytes(int(n)) for n in random.integers(1, 1500, 500))
    yield encode("/mossar/frame", "sidb", "p9", 0, float("nan"), b"\x7f\xc0\0\0" * 6)
    yield encode("/joint", "ssss", "head", "one", "x", "y")
    for k in range(300):  # people and joints without end
        yield encode("/joint", "sifff", f"joint{k}", k, 0.1, 0.2, 0.3)
        yield encode("/lost_user", "i", k)
    for k in range(200):  # a clock that runs backwards
        yield encode("/mossar/frame", "sidb", "back", k, -float(k), b"\0\0\x80\x3f" * 6)


def test_rubbish_floods_and_readers_that_never_read_do_no_harm(start, ports):
    zmq_in, osc_in, zmq_out, ws_out, control = ports
    running = start()
    lazy = subscribed(zmq_out)
    lazy.setsockopt(zmq.RCVHWM, 1)
    page = socket.create_connection(("127.0.0.1", ws_out))
    page.sendall(
        b"GET / HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
    wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender = zmq.Context.instance().socket(zmq.PUB)
    sender.setsockopt(zmq.LINGER, 0)
    sender.connect(f"tcp://127.0.0.1:{zmq_in}")
    sizes = []
    for turn in range(6):
        for k, data in enumerate(rubbish()):
            wire.sendto(data[:65_500], ("127.0.0.1", osc_in))
            sender.send_multipart([b"x", data])
            if k < 700:  # more than there is room for, who come back
                name = f"someone{turn}-{k % 300}"
                sender.send_json({"type": "frame", "performer": name, "t": k / 60, "xyz": [[0, 1, None]] * 3})
            if k % 50 == 0:
                time.sleep(0.01)
        come_to_rest(control)
        for k in range(120):
            xyz = [[0, 1, 0], [np.sin(k / 5), 1, 0]]
            sender.send_json({"type": "frame", "performer": "ann", "t": 1000 * turn + k / 60, "xyz": xyz})
        stats = frames_of("ann", 120 * (turn + 1), control)
        sizes.append(resident(running.pid))
    for opened in (lazy, page, wire, sender):
        opened.close()
    said = ended(running)
    assert stats["frames"] == 720, stats
    assert stats["malformed"] > 1000
    assert sizes[-1] - sizes[3] < 30, f"MiB grow: {sizes}; {said}"


def test_a_pipe_that_is_never_read_holds_up_neither_frames_nor_the_end(process, ports, tmp_path):
    _, _, zmq_out, _, control = ports
    read, write = os.pipe()
    with (tmp_path / "said").open("wb") as said:
        running = process(
            "run", "demo:?fps=240&performers=2", "--speed", "4", "--limbs", "--to", "-", "--to",
            f"zmq+bind://127.0.0.1:{zmq_out}", "--control", f"zmq+bind://127.0.0.1:{control}",
            stdout=write, stderr=said,
        )  # fmt: skip
        os.close(write)
        try:
            asked(control, {"get": "settings"}, 100)
            with subscribed(zmq_out) as reading:
                for _ in range(400):  # twice as much as fits into the pipe
                    assert reading.recv_multipart()
            before = sum(row["frames"] for row in asked(control, {"get": "stats"}).values())
            time.sleep(1.0)
            assert sum(row["frames"] for row in asked(control, {"get": "stats"}).values()) > before
            running.send_signal(signal.SIGINT)
            assert running.wait(30) == 130
        finally:
            os.close(read)
    told = (tmp_path / "said").read_text()
    assert "standard output does not take its events" in told
    assert "Traceback" not in told


def resident(pid):
    """Return the memory of a process in MiB."""
    if sys.platform != "linux":
        return 0.0
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20
