"""Send poses of your own to mossar: a pose script in thirty lines, over ZeroMQ.

Start `mossar run zmq+bind://127.0.0.1:5555`, then this program. Where it computes a swinging arm, put your camera.
"""

import math
import sys
import time

import zmq

ENDPOINT = sys.argv[1] if len(sys.argv) > 1 else "tcp://127.0.0.1:5555"
SECONDS = float(sys.argv[2]) if len(sys.argv) > 2 else 20.0
FPS = 60.0
META = {"type": "meta", "performer": "p1", "names": ["hip", "left_hand", "right_hand"], "parents": [-1, 0, 0]}


def your_pose(t: float) -> list[list[float] | None]:
    """Return [x, y, z] in metres for each joint, None where one is missing: two seconds of rest, two of swinging."""
    swing = math.sin(6 * t) if t % 4 > 2 else 0.0
    return [[0, 1, 0], [-0.3, 1 + 0.4 * swing, 0.3], [0.3, 1 - 0.4 * swing, 0.3]]


with zmq.Context() as context, context.socket(zmq.PUB) as out:
    out.connect(ENDPOINT)
    time.sleep(0.5)  # a connection takes a moment, and PUB does not wait for it
    began = time.monotonic()
    for number in range(int(SECONDS * FPS)):
        if number % FPS == 0:  # now and then again, for who starts later
            out.send_json(META)
        t = number / FPS
        out.send_json({"type": "frame", "performer": "p1", "seq": number, "t": t, "xyz": your_pose(t)})
        time.sleep(max(0.0, began + t - time.monotonic()))
    time.sleep(0.2)  # the last messages go out
