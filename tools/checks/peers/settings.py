"""Search the settings of the peers again: `python -m checks.peers.settings DIR [NAME...]`."""

import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path

from checks.peers.peer import Parameters, Peer
from checks.peers.runner import run_peer
from checks.peers.table import PEERS
from mossar_tools.evaluation.metrics import median
from mossar_tools.evaluation.takes import load_folder
from mossar_tools.evaluation.trial import groups_of


def main() -> None:
    """Print the best settings of every peer for every level, best first."""
    groups = groups_of(load_folder(Path(sys.argv[1])))
    for peer in PEERS:
        if sys.argv[2:] and peer.library not in sys.argv[2:]:
            continue
        for level, takes in groups.items():
            tried = [(run_peer(takes, peer, chosen), chosen) for chosen in _combinations(peer)]
            tried.sort(key=lambda one: -one[0].scores.f1)
            for own, chosen in tried[:3]:
                delay = median(own.scores.delays)
                print(
                    f"{peer.name}, {level}: F1 {own.scores.f1:.3f}, delay {delay:.2f} s, {dict(chosen)}",
                    flush=True,
                )


def _combinations(peer: Peer) -> Iterator[Parameters]:
    for values in product(*peer.grid.values()):
        yield dict(zip(peer.grid, values, strict=True))


if __name__ == "__main__":
    main()
