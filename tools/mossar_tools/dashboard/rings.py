"""Rings: progress and count of the move that is followed, large, over the scene."""

from html import escape

from mossar_tools.dashboard.glimpse import Glimpse, Pursuit

MOST = 4  # performers with a ring
RADIUS = 52.0  # of a ring in a box of 120


def rings(glimpses: list[Glimpse]) -> str:
    """Return a ring for each performer who is followed, with the count within it and the limb that strays beside it."""
    own = [(glimpse.performer, glimpse.pursued[0]) for glimpse in glimpses if glimpse.pursued]
    if not own:
        return ""
    parts = [_ring(performer if len(glimpses) > 1 else "", pursuit) for performer, pursuit in own[:MOST]]
    return f'<div class="mossar m-rings" id="mossar-rings">{"".join(parts)}</div>'


def followed_rows(pursued: list[Pursuit]) -> str:
    """Return a row for each move that is followed: its count, and how the last performance went."""
    rows = "".join(
        f"<tr><td>{escape(one.name)}</td><td><b>{one.count}</b></td><td>{_score(one)}</td>"
        f"<td>{escape(_limb(one))}</td></tr>"
        for one in sorted(pursued, key=lambda one: one.name)
    )
    head = "<tr><th>followed</th><th>done</th><th>score</th><th>strays most</th></tr>"
    return f'<div class="mossar m-card" id="mossar-followed"><table>{head}{rows}</table></div>'


def _ring(performer: str, pursuit: Pursuit) -> str:
    round_ = 2 * 3.141593 * RADIUS
    share = pursuit.progress or 0.0
    state = "idle" if pursuit.progress is None else "made"
    circle = f'cx="60" cy="60" r="{RADIUS:g}"'
    said = [f"<b>{escape(pursuit.name)}</b>", escape(_limb(pursuit))]
    if performer:
        said.insert(0, escape(performer))
    if pursuit.progress is None and pursuit.score is not None:
        said.append(f"score {pursuit.score:.2f}")
    elif pursuit.progress is not None:
        said.append(f"tempo {pursuit.tempo:.1f}")
    return (
        f'<div class="m-ring {state}" data-progress="{share:.3f}"><svg viewBox="0 0 120 120"><circle class="ground" {circle}/>'
        f'<circle class="share" {circle} stroke-dasharray="{share * round_:.1f} {round_:.1f}"/>'
        f'<text x="60" y="60">{pursuit.count}</text></svg><span>{"<br>".join(filter(None, said))}</span></div>'
    )


def _limb(pursuit: Pursuit) -> str:
    return f"{pursuit.limb.replace('_', ' ')} {pursuit.angle:.0f}°" if pursuit.limb else ""


def _score(pursuit: Pursuit) -> str:
    return "" if pursuit.score is None else f"{pursuit.score:.2f}"
