"""Table: the peers there are."""

from typing import Final

from checks.peers.claspy_class import CLASP
from checks.peers.peer import Peer
from checks.peers.river_drift import ADWIN, PAGE_HINKLEY
from checks.peers.ruptures_window import WINDOW
from checks.peers.stumpy_floss import FLOSS

PEERS: Final[tuple[Peer, ...]] = (ADWIN, PAGE_HINKLEY, FLOSS, CLASP, WINDOW)
