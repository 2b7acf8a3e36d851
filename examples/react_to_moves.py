"""A game that reacts to moves: its loop.

Show the moves (`mossar teach moves.json SOURCE --name punch`), start
`mossar run SOURCE --moves moves.json --emit move,stream --to 'zmq+bind://127.0.0.1:5556?encoding=json'`, then this program;
it ends with the take.
"""

import json
import sys

import zmq

ENDPOINT = sys.argv[1] if len(sys.argv) > 1 else "tcp://127.0.0.1:5556"
FRAME = 16  # ms, of the game


class Game:
    """A dragon that can be punched."""

    def __init__(self) -> None:
        self.health = 3
        self.over = False

    def react(self, event: dict[str, object]) -> None:
        """Let something happen in the game."""
        if event["type"] == "stream" and event["event"] == "ended":
            self.over = True
        elif event["type"] == "move" and event["status"] == "confirmed":
            self.health -= 1
            print(f"{event['name']} with the {event['limb']}: the dragon has {self.health} left", flush=True)

    def draw(self) -> None:
        """Draw a frame; a real game has more to do here."""


def main() -> None:
    """Run the game."""
    game = Game()
    with zmq.Context() as context, context.socket(zmq.SUB) as events:
        events.connect(ENDPOINT)
        events.subscribe("mossar.")
        while not game.over:
            if events.poll(FRAME):  # wait at most a frame of the game for news
                _, data = events.recv_multipart()
                game.react(json.loads(data))
            game.draw()


main()
