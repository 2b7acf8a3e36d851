"""Pictures of scenes: where people went, when they were hidden, and which slots they got."""

from pathlib import Path

import numpy as np

from checks.people.judge import Verdict
from checks.people.scenes import Scene

_COLOURS = ("#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#8c564b")


def draw(scene: Scene, verdict: Verdict, path: Path) -> None:
    """Draw a scene: the tracker's ids above, the slots below; both over the place across the stage."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(14, 9))
    panels = figure.subplots(3, 1)
    across = np.nanmean(scene.positions[..., 0], axis=2)
    for panel, numbers, what in ((panels[0], scene.ids, "id"), (panels[1], verdict.slots, "slot")):
        for person in range(len(across)):
            for number in np.unique(numbers[person][numbers[person] > 0]):
                here = np.where(numbers[person] == number, across[person], np.nan)
                colour = _COLOURS[(int(number) - 1) % len(_COLOURS)]
                panel.plot(scene.times, here, color=colour, linewidth=2)
                first = int(np.flatnonzero(numbers[person] == number)[0])
                panel.text(scene.times[first], across[person, first], f"{what} {number}", color=colour)
        panel.set_ylabel(f"across, m ({what})")
    moment = len(scene.times) // 2
    for person in range(len(across)):
        pose = scene.positions[person, moment]
        for joint, parent in enumerate(scene.skeleton.parents):
            if parent >= 0:
                panels[2].plot(*pose[[joint, parent]].T[:2], color=_COLOURS[person])
    panels[2].set_aspect("equal")
    panels[2].set_title(f"{verdict.right} of {verdict.frames} frames right; " + "; ".join(scene.incidents))
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=70)
