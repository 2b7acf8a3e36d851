"""Receive events over ZeroMQ: the loop of a program that reacts.

Start `mossar run SOURCE --to 'zmq+bind://127.0.0.1:5556?encoding=json'`, then this program; it ends with the take.
"""

import json
import sys

import zmq

ENDPOINT = sys.argv[1] if len(sys.argv) > 1 else "tcp://127.0.0.1:5556"

with zmq.Context() as context, context.socket(zmq.SUB) as events:
    events.connect(ENDPOINT)
    events.subscribe("mossar.")  # "mossar.key_frame.p1." for the key frames of one performer
    while True:
        topic, data = events.recv_multipart()
        event = json.loads(data)  # without ?encoding=json: msgpack.unpackb(data)
        if event["type"] == "key_frame" and event["status"] == "confirmed":
            print(f"{event['time']:7.2f} s  {event['performer']}: {event['kind']}", flush=True)
        elif event["type"] == "stream" and event["event"] == "ended":
            break
