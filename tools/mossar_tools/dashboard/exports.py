"""Exports: what the browser downloads, the key frames as a table and the whole take as a picture."""

import csv
import io

from mossar_tools.dashboard.glimpse import Mark

COLUMNS = ("performer", "time", "frame", "kind", "velocity", "strength", "stands")


def key_frames_csv(found: list[tuple[str, Mark]]) -> bytes:
    """Return key frames as a table.

    Args:
        found: Performer and key frame.

    Example:
        >>> key_frames_csv([("p1", Mark("7", 0.25, 7, "onset", 0.1, None, True))]).decode().splitlines()[1]
        'p1,0.2500,7,onset,0.1000,,yes'
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    for performer, mark in found:
        strength = "" if mark.strength is None else f"{mark.strength:.4f}"
        stands = "yes" if mark.kept else "no"
        cells = [f"{mark.time:.4f}", mark.frame, mark.kind, f"{mark.velocity:.4f}", strength, stands]
        table.writerow([performer, *cells])
    return text.getvalue().encode()
