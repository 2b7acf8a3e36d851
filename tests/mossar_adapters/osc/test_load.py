"""What the source must keep up with."""

import socket
import subprocess
import sys
import time

import numpy as np

from mossar_adapters.address import parse_url
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.osc.assembly.known_joints import MAX_NAMES
from mossar_adapters.osc.encode import encode
from mossar_adapters.osc.source import OscSource
from mossar_adapters.receiving.batch import MAX_PERFORMERS

SENDER = """
import socket, sys, time
from mossar_adapters.osc.encode import encode
port, frames, fps, joints = map(int, sys.argv[1:])
wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
place = ("127.0.0.1", port)
started = time.monotonic()
for k in range(frames):
    time.sleep(max(0.0, started + k / fps - time.monotonic()))
    for j in range(joints):
        wire.sendto(encode(f"/pose/joint{j}", "fff", 0.1 * j, 1.0, 0.001 * k), place)
"""


def test_six_hundred_frames_a_second_of_single_joints_arrive_without_loss(hear):
    query = "profile=generic&pattern=/pose/{joint}"
    source = OscSource(parse_url(f"osc://127.0.0.1:0?{query}"), ReadOptions(unit="m"))
    command = [sys.executable, "-c", SENDER, str(source.port), "300", "600", "33"]
    environment = {"PYTHONPATH": ":".join(sys.path)}
    heard = hear(source, lambda: subprocess.run(command, check=True, env=environment))
    assert source.counters.received == 300 * 33
    assert source.counters.kernel_drops == 0
    assert heard.count() == 300
    assert np.isfinite(heard.positions()).all()
    depth = np.repeat((0.001 * np.arange(300)).astype(np.float32), 33).reshape(300, 33)
    assert np.array_equal(heard.positions()[:, :, 2], depth)


def test_a_flood_of_names_and_senders_does_not_grow_without_bound(hear):
    source = OscSource(parse_url("osc://127.0.0.1:0"))
    wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def send():
        for k in range(3000):
            wire.sendto(encode("/joint", "sifff", f"joint{k}", 1, 0, 0, 0), ("127.0.0.1", source.port))
            wire.sendto(encode("/joint", "sifff", "head", k, 0, 0, 0), ("127.0.0.1", source.port))
            wire.sendto(encode(f"/unknown/{k}", "f", 0), ("127.0.0.1", source.port))
            if k % 100 == 0:
                time.sleep(0.01)

    hear(source, send)
    wire.close()
    assert len(source.counters.seen) <= 8
    assert len(source.decoder._batch._lines) <= MAX_PERFORMERS
    osceleton = source.decoder._routes._profiles[2]
    assert len(osceleton._joints._performers) <= 64
    assert all(
        len(performer._known.names) <= MAX_NAMES for performer in osceleton._joints._performers.values()
    )
