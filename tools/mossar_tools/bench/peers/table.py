"""Table: the peers there are."""

from typing import Final

from mossar_tools.bench.peers.arcs import FLOSS
from mossar_tools.bench.peers.class_profile import CLASP
from mossar_tools.bench.peers.drift import ADWIN, PAGE_HINKLEY
from mossar_tools.bench.peers.peer import Peer
from mossar_tools.bench.peers.sliding import WINDOW

PEERS: Final[tuple[Peer, ...]] = (ADWIN, PAGE_HINKLEY, FLOSS, CLASP, WINDOW)
