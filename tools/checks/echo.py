"""A plain echo: sends back the messages that it receives, without any work on them.

`python -m checks.echo osc 9000 9001` takes datagrams at the first port and sends them to the second one,
`… zmq 9000 9001` binds a SUB socket to the first and a PUB socket to the second. Nothing of Mossar is in it: its
time is the floor under every delay that is measured on this machine.
"""

import argparse
import socket

import zmq

_MAX_DATAGRAM = 65_535  # bytes


def main() -> None:
    """Echo until the process is ended."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("transport", choices=("osc", "zmq"))
    parser.add_argument("into", type=int, metavar="IN", help="port to listen to")
    parser.add_argument("out", type=int, metavar="OUT", help="port to send to")
    given = parser.parse_args()
    {"osc": _datagrams, "zmq": _messages}[given.transport](given.into, given.out)


def _datagrams(into: int, out: int) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as wire:
        wire.bind(("127.0.0.1", into))
        while True:
            wire.sendto(wire.recv(_MAX_DATAGRAM), ("127.0.0.1", out))


def _messages(into: int, out: int) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    heard, told = context.socket(zmq.SUB), context.socket(zmq.PUB)
    heard.setsockopt(zmq.SUBSCRIBE, b"")
    heard.bind(f"tcp://127.0.0.1:{into}")
    told.bind(f"tcp://127.0.0.1:{out}")
    while True:
        told.send_multipart(heard.recv_multipart())


if __name__ == "__main__":
    main()
