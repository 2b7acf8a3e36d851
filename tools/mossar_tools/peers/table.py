"""Table: the peers there are."""

from typing import Final

from mossar_tools.peers.claspy_class import CLASP
from mossar_tools.peers.peer import Peer
from mossar_tools.peers.river_drift import ADWIN, PAGE_HINKLEY
from mossar_tools.peers.ruptures_window import WINDOW
from mossar_tools.peers.stumpy_floss import FLOSS

PEERS: Final[tuple[Peer, ...]] = (ADWIN, PAGE_HINKLEY, FLOSS, CLASP, WINDOW)
