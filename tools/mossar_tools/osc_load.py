"""Measure what the OSC source keeps up with: `python -m mossar_tools.osc_load --seconds 30`.

A second process sends single-joint messages over loopback; printed are losses and the CPU time of the source.
"""

import argparse
import multiprocessing
import socket
import time

from mossar_adapters.address import parse_url
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.osc.encode import encode
from mossar_adapters.osc.source import OscSource
from mossar_stream.frames import Frames

_QUIET = 5  # tenths of a second without a frame that end the measurement


def main() -> None:
    """Send, receive, print one line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--fps", type=float, default=600.0, help="frames per second")
    parser.add_argument("--joints", type=int, default=33, help="messages per frame")
    given = parser.parse_args()
    source = OscSource(
        parse_url("osc://127.0.0.1:0?profile=generic&pattern=/pose/{joint}"), ReadOptions(unit="m")
    )
    frames = round(given.seconds * given.fps)
    sender = multiprocessing.get_context("spawn").Process(
        target=send, args=(source.port, frames, given.fps, given.joints), daemon=True
    )
    sender.start()
    received, seconds = receive(source, given.seconds + 30)
    counters = source.counters
    sent = frames * given.joints
    print(
        f"{sent} messages sent, {counters.received} received, {counters.kernel_drops} dropped by the kernel;"
        f" {received} of {frames} frames; {seconds:.2f} s of CPU ({100 * seconds / given.seconds:.0f} % of a core)"
    )


def send(port: int, frames: int, fps: float, joints: int) -> None:
    """Send frames at a steady pace."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as wire:
        started = time.monotonic()
        for k in range(frames):
            time.sleep(max(0.0, started + k / fps - time.monotonic()))
            for joint in range(joints):
                data = encode(f"/pose/joint{joint}", "fff", 0.1 * joint, 1.0, 0.001 * k)
                wire.sendto(data, ("127.0.0.1", port))


def receive(source: OscSource, limit: float) -> tuple[int, float]:
    """Return the frames that came until the sender fell silent, and the CPU time that took (s)."""
    received = quiet = 0
    started, used = time.monotonic(), time.process_time()
    for item in source.items():
        received += len(item) if isinstance(item, Frames) else 0
        quiet = quiet + 1 if item is None and received else 0
        if quiet == _QUIET or time.monotonic() - started > limit:
            source.close()
    return received, time.process_time() - used


if __name__ == "__main__":
    main()
