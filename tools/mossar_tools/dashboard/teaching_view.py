"""View of teaching: the countdown in large letters, and the examples as small figures."""

from functools import lru_cache
from html import escape

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Example, Moves, Skeleton
from mossar_tools.dashboard.asking import asking
from mossar_tools.dashboard.teaching import TeachingState, mark_of
from mossar_tools.stick_figures import head_of, project, view_of

MOST = 60  # examples shown, the last ones
_WIDTH, _HEIGHT, _MARGIN = 58, 74, 6  # px of a figure
_FAINT = 3  # poses drawn faintly before the one that reaches farthest


def countdown(state: TeachingState) -> str:
    """Return the large text for a person who shows a move."""
    large = {
        "count": str(state.seconds),
        "watch": "now",
        "again": "again",
        "taken": "taken",
        "failed": "again",
    }
    if state.phase == "idle":
        return ""
    small = {
        "count": f"get ready for {state.name}",
        "watch": state.message or f"do {state.name}, then rest",
        "again": f"{state.message}; do {state.name} again, or press Keep",
    }.get(state.phase, state.message)
    return (
        f'<div class="mossar m-count {state.phase}" id="mossar-count"><b>{large[state.phase]}</b>'
        f"<span>{escape(small)}</span></div>"
    )


def examples_card(moves: Moves | None, message: str) -> str:
    """Return the examples as figures, each with a button that forgets it, and the last message."""
    rows = [f'<div class="dim" id="mossar-taught">{escape(message)}</div>']
    if moves is None or not len(moves):
        rows.append(
            '<div class="dim">No examples yet. Stand still, press Teach, do the move, stand still.</div>'
        )
        return f'<div class="mossar m-card">{"".join(rows)}</div>'
    first = max(0, len(moves) - MOST)
    shown = list(enumerate(moves.examples))[first:]
    for name in dict.fromkeys(example.name for _, example in shown):
        own = [(place, example) for place, example in shown if example.name == name]
        figures = "".join(_figure(place, example, moves.skeleton) for place, example in own)
        rows.append(f'<div class="m-move"><b>{escape(name)}</b> <span class="dim">{len(own)}</span></div>')
        rows.append(f'<div class="m-examples">{figures}</div>')
    if first:
        rows.append(f'<div class="dim">and {first} earlier ones</div>')
    return f'<div class="mossar m-card">{"".join(rows)}</div>'


def _figure(place: int, example: Example, skeleton: Skeleton) -> str:
    seconds = seconds_of_example(example, skeleton)
    ask = escape(asking("mossar/forget", f"'{place}-{mark_of(example)}'"), quote=True)
    title = f"{escape(example.name)}, {seconds:.2f} s"
    return (
        f'<figure class="m-example" data-name="{escape(example.name, quote=True)}">{drawing(example, skeleton)}'
        f'<figcaption>{seconds:.1f} s</figcaption><button title="forget {title}" onclick="{ask}">&times;</button></figure>'
    )


def seconds_of_example(example: Example, skeleton: Skeleton) -> float:
    """Return the duration of an example, s."""
    return (len(example.positions) // (3 * len(skeleton)) - 1) / example.fps


@lru_cache(maxsize=2 * MOST)
def drawing(example: Example, skeleton: Skeleton) -> str:
    """Return the pose that is farthest from the first one, and some on the way to it, as a small picture."""
    poses = example.metres(len(skeleton)).astype(np.float64)
    centre = poses[:, skeleton.root] if skeleton.root >= 0 else poses.mean(axis=1)
    local = poses - centre[:, None]
    away = np.linalg.norm(local - local[0], axis=2).sum(axis=1)
    farthest = int(np.argmax(away))
    chosen = [round(farthest * k / _FAINT) for k in range(_FAINT + 1)]
    view = view_of(skeleton, poses)
    flat = np.stack([project(poses[place], view) for place in chosen])
    low, high = flat.min(axis=(0, 1)), flat.max(axis=(0, 1))
    scale = min(
        (_WIDTH - 2 * _MARGIN) / max(high[0] - low[0], 1e-6),
        (_HEIGHT - 2 * _MARGIN) / max(high[1] - low[1], 1e-6),
    )
    placed = (flat - (low + high) / 2) * (scale, -scale) + (_WIDTH / 2, _HEIGHT / 2)
    bodies = [_body(pose, skeleton, "faint" if k < _FAINT else "") for k, pose in enumerate(placed)]
    return f'<svg width="{_WIDTH}" height="{_HEIGHT}">{"".join(bodies)}</svg>'


def _body(pose: NDArray[np.float64], skeleton: Skeleton, classes: str) -> str:
    bones = "".join(
        f"M{pose[a, 0]:.1f} {pose[a, 1]:.1f}L{pose[b, 0]:.1f} {pose[b, 1]:.1f}" for a, b in skeleton.bones()
    )
    head = head_of(skeleton)
    dots = [head] if head >= 0 else [] if skeleton.bones() else range(len(skeleton))
    marks = "".join(f'<circle cx="{pose[j, 0]:.1f}" cy="{pose[j, 1]:.1f}" r="2.6"/>' for j in dots)
    return f'<g class="{classes}"><path d="{bones}"/>{marks}</g>'
