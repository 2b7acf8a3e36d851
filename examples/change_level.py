"""Ask a running mossar for its counters, and change its level: `mossar run SOURCE --control zmq+bind://127.0.0.1:5560`."""

import json
import sys

import zmq

ENDPOINT = sys.argv[1] if len(sys.argv) > 1 else "tcp://127.0.0.1:5560"

with zmq.Context() as context, context.socket(zmq.REQ) as asking:
    asking.setsockopt(zmq.LINGER, 0)  # nobody waits for an answer any more after Ctrl-C
    asking.connect(ENDPOINT)
    for request in ({"get": "stats"}, {"set": {"level": "posture"}}, {"get": "settings"}):
        asking.send_json(request)
        answer = json.loads(asking.recv())
        if not answer["ok"]:
            sys.exit(answer["error"])
        print(request, "->", answer["value"])
