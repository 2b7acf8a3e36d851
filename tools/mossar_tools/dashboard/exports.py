"""Exports: what the browser downloads, the key frames as a table and the whole take as a picture."""

from collections.abc import Sequence

from mossar_adapters.table_text import csv_text
from mossar_tools.marks import Mark

COLUMNS = ("performer", "time", "frame", "kind", "velocity", "strength", "stands")


def key_frames_csv(found: list[tuple[str, Mark]]) -> bytes:
    """Return key frames as a table.

    Args:
        found: Performer and key frame.

    Example:
        >>> key_frames_csv([("p1", Mark("7", 0.25, 7, "onset", 0.1, None, True))]).decode().splitlines()[1]
        'p1,0.2500,7,onset,0.1000,,yes'
    """
    rows: list[Sequence[object]] = [COLUMNS]
    for performer, mark in found:
        strength = "" if mark.strength is None else f"{mark.strength:.4f}"
        stands = "yes" if mark.kept else "no"
        cells = [f"{mark.time:.4f}", mark.frame, mark.kind, f"{mark.velocity:.4f}", strength, stands]
        rows.append([performer, *cells])
    return csv_text(rows).encode()
