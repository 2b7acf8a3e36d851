"""Measure the load that `mossar run` bears, and the time from a frame to its event.

`python -m checks.load osc` sends 600 frames/s of 33 single-joint messages for 30 s, `… zmq` 2000 frames/s;
losses are printed. With `--delay` a performer moves at 60 frames/s, and the time from sending a frame to receiving
its event is measured, beside that of a plain echo.
"""

import argparse
import contextlib
import socket
import time
from collections.abc import Callable

import numpy as np

from checks.delay import delays, in_words
from checks.run_process import RunProcess, free_port
from mossar_adapters.address import parse_url
from mossar_adapters.osc.encode import encode
from mossar_adapters.source import Meta
from mossar_adapters.zeromq.sink import ZmqFrameSink
from mossar_stream import Frames, Skeleton

RATES = {"osc": 600.0, "zmq": 2000.0}  # frames/s
LOSSES = ("gaps", "malformed", "kernel_drops", "queue_dropped", "out_of_order")


def main() -> None:
    """Send, receive, print one line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("transport", choices=list(RATES))
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--fps", type=float, help="frames per second (default: 600 for osc, 2000 for zmq)")
    parser.add_argument(
        "--joints", type=int, default=33, help="joints of a frame; over osc each is a message"
    )
    parser.add_argument("--delay", action="store_true", help="measure delays, at 60 frames/s")
    given = parser.parse_args()
    if given.delay:
        print(in_words(given.transport, delays(given.transport, given.seconds)))
    else:
        fps = given.fps or RATES[given.transport]
        print(load(given.transport, round(given.seconds * fps), fps, given.joints))


def load(transport: str, frames: int, fps: float, joints: int) -> str:
    """Send frames at a steady pace to `mossar run`, and return a line on the received ones.

    Args:
        transport: `osc` or `zmq`.
        frames: Number of frames.
        fps: Per second.
        joints: Of each frame.
    """
    port = free_port(socket.SOCK_DGRAM if transport == "osc" else socket.SOCK_STREAM)
    url = f"osc://127.0.0.1:{port}?profile=generic&pattern=/pose/{{joint}}&unit=m"
    with contextlib.ExitStack() as opened:
        send = (
            _single_joints(port, joints, opened)
            if transport == "osc"
            else _frame_maps(port, joints, fps, opened)
        )
        run = opened.enter_context(
            RunProcess(url if transport == "osc" else f"zmq+bind://127.0.0.1:{port}", "-")
        )
        late = 0.0
        started = time.monotonic()
        for k in range(frames):
            due = started + k / fps
            time.sleep(max(0.0, due - time.monotonic()))
            late = max(late, time.monotonic() - due)
            send(k)
        seconds = time.monotonic() - started
        stats = run.settled_stats().get("p1", {})
    lost = (
        ", ".join(f"{stats[name]} {name.replace('_', ' ')}" for name in LOSSES if stats.get(name))
        or "nothing lost"
    )
    return (
        f"{transport}: {frames} frames of {joints} joints sent in {seconds:.2f} s ({frames / seconds:.0f} per second, at "
        f"most {late * 1000:.0f} ms late), {stats.get('frames', 0)} segmented; {lost}"
    )


def _single_joints(port: int, joints: int, opened: contextlib.ExitStack) -> Callable[[int], None]:
    wire = opened.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))

    def send(number: int) -> None:
        for joint in range(joints):
            data = encode(f"/pose/joint{joint}", "fff", 0.1 * joint, 1.0, float(np.sin(number / 600)))
            wire.sendto(data, ("127.0.0.1", port))

    return send


def _frame_maps(port: int, joints: int, fps: float, opened: contextlib.ExitStack) -> Callable[[int], None]:
    sink = ZmqFrameSink(parse_url(f"zmq://127.0.0.1:{port}?wait=120"))
    opened.callback(sink.close)
    sink.announce(Meta("p1", Skeleton(tuple(f"joint{i}" for i in range(joints)))))
    positions = np.zeros((1, joints, 3), np.float32)

    def send(number: int) -> None:
        positions[0, :, 0] = np.sin(number / 600)
        sink.send_frames(Frames(positions, np.array([number / fps])))

    return send


if __name__ == "__main__":
    main()
