"""Receive key frames and recognised moves over OSC, as games and patches do.

Start `mossar run SOURCE --to osc://127.0.0.1:9000`, then this program; it ends with the take.
"""

import sys
from contextlib import suppress

from pythonosc.dispatcher import Dispatcher
from pythonosc.osc_server import BlockingOSCUDPServer

PORT = int(sys.argv[1]) if len(sys.argv) > 1 else 9000


def key_frame(_: str, performer: str, status: str, kind: str, *numbers: float) -> None:
    """React to `/mossar/key_frame`: take, frame, time, decided_time, velocity, strength and rev are the numbers."""
    if status == "confirmed":
        print(f"{numbers[2]:7.2f} s  {performer}: {kind}", flush=True)


def move(_: str, performer: str, status: str, name: str, limb: str, *numbers: float) -> None:
    """React to `/mossar/move`: take, start, end, decided_time, score and rev are the numbers."""
    if status == "confirmed":
        print(f"{numbers[1]:7.2f} s  {performer}: {name} ({limb})", flush=True)


def stream(_: str, performer: str, event: str, *reason_and_take: object) -> None:
    """React to `/mossar/stream`: a take started, stalled, ended."""
    if event == "ended":
        ended.append((performer, reason_and_take))


ended: list[object] = []
dispatcher = Dispatcher()
dispatcher.map("/mossar/key_frame", key_frame)
dispatcher.map("/mossar/move", move)
dispatcher.map("/mossar/stream", stream)
with suppress(KeyboardInterrupt), BlockingOSCUDPServer(("127.0.0.1", PORT), dispatcher) as server:
    while not ended:
        server.handle_request()
