"""Who may ask the dashboard's server for something."""

import gc
import socket
import time

import msgspec
import pytest
import viser
from websockets.sync.client import connect

from mossar_adapters.urls import open_sink
from mossar_stream import Settings
from mossar_tools.dashboard.live import LiveShow
from mossar_tools.dashboard.page import Page
from mossar_tools.dashboard.recorded import RecordedShow
from mossar_tools.dashboard.server import _guarded, open_server
from mossar_tools.dashboard.visitors import Visitors
from mossar_tools.errors import UsageError
from mossar_tools.loaded_recording import load_recording


@pytest.mark.parametrize("host", ["192.0.2.1", "2001:db8::1"])
def test_a_host_that_is_no_address_of_this_computer_is_refused_at_once(host):
    with pytest.raises(UsageError, match="is not an address of this computer"):
        open_server(host, 0, {}, Visitors(host, print))


def test_pages_of_other_sites_are_turned_away():
    page = Page(LiveShow(Settings()), 0)
    try:
        for origin in ("http://evil.example", "null", f"http://127.0.0.1.evil.example:{page.port}"):
            assert answer(page.port, origin).startswith(b"HTTP/1.1 403"), origin
        for origin in (page.url, f"http://localhost:{page.port}"):
            assert answer(page.port, origin).startswith(b"HTTP/1.1 101"), origin
    finally:
        page.close()


def test_other_servers_that_start_meanwhile_are_left_alone():
    with _guarded({}, Visitors("127.0.0.1", lambda _: None)):
        sink = open_sink("ws://127.0.0.1:0?origin=https://game.example")
    try:
        assert answer(sink.port, "https://game.example").startswith(b"HTTP/1.1 101")
    finally:
        sink.close()


def answer(port, origin):
    """Return what a WebSocket gets that says it comes from there."""
    with socket.create_connection(("127.0.0.1", port), 10) as asking:
        asking.sendall(
            f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nOrigin: {origin}\r\nUpgrade: websocket\r\n"
            "Connection: Upgrade\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
            "Sec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        return asking.recv(1024)


def test_only_the_page_itself_moves_the_playhead():
    whole = load_recording("demo:?seconds=6")
    show = RecordedShow([("p1", whole)], Settings(range="file"))
    show.player.paused = True
    page = Page(show, 0)
    ours = f"Host: 127.0.0.1:{page.port}\r\nX-Mossar: 1\r\n"
    try:
        for headers in (
            f"Host: 127.0.0.1:{page.port}\r\n",
            f"Host: evil.example:{page.port}\r\nX-Mossar: 1\r\n",
            f"{ours}Origin: http://evil.example\r\n",
        ):
            assert fetched(page.port, "mossar/seek?2.5", headers).startswith(b"HTTP/1.1 403")
        for rubbish in ("", "nan", "x", "1e999"):
            assert fetched(page.port, f"mossar/seek?{rubbish}", ours).startswith(b"HTTP/1.1 400")
        assert show.player.place < 1
        assert fetched(page.port, "mossar/seek?2.5", ours).startswith(b"HTTP/1.1 200")
        assert show.player.place == 2.5
        assert fetched(page.port, "mossar/window?390x800", ours).startswith(b"HTTP/1.1 200")
    finally:
        page.close()


def fetched(port, path, headers):
    with socket.create_connection(("127.0.0.1", port), 10) as asking:
        asking.sendall(f"GET /{path} HTTP/1.1\r\n{headers}\r\n".encode())
        return asking.recv(1024)


@pytest.mark.parametrize("value", ["nonsense", None, [], float("nan"), float("inf"), b"x", "\x1b[2J"])
def test_what_is_no_value_of_a_control_changes_nothing_and_prints_no_traceback(value, capfd, caplog):
    caplog.set_level("DEBUG", "mossar")
    server = open_server("127.0.0.1", 0, {}, Visitors("127.0.0.1", print))
    try:
        slider = server.gui.add_slider("strength", 0, 10, 1, 5)
        url = f"ws://127.0.0.1:{server.get_port()}/"
        with connect(url, subprotocols=[f"viser-v{viser.__version__}"], max_size=None) as visitor:
            update = {"type": "GuiUpdateMessage", "uuid": slider._impl.uuid, "updates": {"value": value}}
            visitor.send(msgspec.msgpack.encode(update))
            end = time.monotonic() + 30
            while "the dashboard: " not in caplog.text and time.monotonic() < end:
                gc.collect()
                time.sleep(0.05)
        assert slider.value == 5
    finally:
        server.stop()
    assert "the dashboard: " in caplog.text
    assert "Traceback" not in capfd.readouterr().err
