"""Rings: progress and count of the move that is followed, large, over the scene."""

from html import escape

from mossar_tools.dashboard.glimpse import FollowedMove, Glimpse

MOST = 4  # performers with a ring
RADIUS = 52.0  # of a ring in a box of 120


def rings(glimpses: list[Glimpse]) -> str:
    """Return a ring for each followed performer, with the count within it and the limb that strays beside it."""
    own = [(glimpse.performer, glimpse.followed_moves[0]) for glimpse in glimpses if glimpse.followed_moves]
    if not own:
        return ""
    parts = [_ring(performer if len(glimpses) > 1 else "", move) for performer, move in own[:MOST]]
    return f'<div class="mossar m-rings" id="mossar-rings">{"".join(parts)}</div>'


def followed_rows(followed_moves: list[FollowedMove]) -> str:
    """Return a row for each move that is followed: its count, and how the last performance went."""
    rows = "".join(
        f"<tr><td>{escape(one.name)}</td><td><b>{one.count}</b></td><td>{_score(one)}</td>"
        f"<td>{escape(_limb(one))}</td></tr>"
        for one in sorted(followed_moves, key=lambda one: one.name)
    )
    head = "<tr><th>followed</th><th>done</th><th>score</th><th>strays most</th></tr>"
    return f'<div class="mossar m-card" id="mossar-followed"><table>{head}{rows}</table></div>'


def _ring(performer: str, move: FollowedMove) -> str:
    round_ = 2 * 3.141593 * RADIUS
    share = move.progress or 0.0
    state = "idle" if move.progress is None else "made"
    circle = f'cx="60" cy="60" r="{RADIUS:g}"'
    said = [f"<b>{escape(move.name)}</b>", escape(_limb(move))]
    if performer:
        said.insert(0, escape(performer))
    if move.progress is None and move.score is not None:
        said.append(f"score {move.score:.2f}")
    elif move.progress is not None:
        said.append(f"tempo {move.tempo:.1f}")
    return (
        f'<div class="m-ring {state}" data-progress="{share:.3f}"><svg viewBox="0 0 120 120"><circle class="ground" {circle}/>'
        f'<circle class="share" {circle} stroke-dasharray="{share * round_:.1f} {round_:.1f}"/>'
        f'<text x="60" y="60">{move.count}</text></svg><span>{"<br>".join(filter(None, said))}</span></div>'
    )


def _limb(move: FollowedMove) -> str:
    return f"{move.limb.replace('_', ' ')} {move.angle:.0f}°" if move.limb else ""


def _score(move: FollowedMove) -> str:
    return "" if move.score is None else f"{move.score:.2f}"
