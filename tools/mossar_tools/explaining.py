"""Explaining: lines about moves that came near, and about examples that are unlike the others."""

from mossar_stream import Explanation, Oddity


def line_of(explanation: Explanation) -> str:
    """Return a line about the nearest move in a movement, and the reason why it was not recognised.

    Example:
        >>> line_of(Explanation("p1", 1.0, 2.1, "jab", "", 0.3, 0.47, 1.8, "hook", 1.0))
        'p1, 1.00 to 2.10 s: jab recognised at a cost of 0.30 (most 0.47); hook costs 1.8 times as much'
    """
    e = explanation
    second = f"; {e.second} costs {_times(e.lead)} as much" if e.second else ""
    known = f"a cost of {e.cost:.2f} (most {e.most:.2f})"
    where = f"{e.performer}, {e.start:.2f} to {e.end:.2f} s: {e.nearest}"
    if not e.reason:
        return f"{where} recognised at {known}{second}"
    why = {
        "cost": "the cost is too high",
        "lead": "the lead is too small",
        "posture": f"the posture is another one, which makes the cost {_times(e.posture)} as high",
        "agreement": "only one comparison said so",
        "pause": "its pause was not over",
    }[e.reason]
    return f"{where} nearest, not recognised at {known}{second}: {why}"


def _times(factor: float) -> str:
    return f"{factor:.1f} times" if factor < 10.0 else "over 10 times"


def lines_of_oddity(name: str, place: int, oddity: Oddity) -> list[str]:
    """Return a line for each difference between an example and the others of its name.

    Args:
        name: Of the move.
        place: Of the example among those of its name, from 1.
        oddity: The difference.

    Example:
        >>> lines_of_oddity("punch", 2, Oddity(("duration",), 0.27, 3.97, 0.99, 0.2, ""))
        ['punch: example 2 takes 0.27 s, the others 3.97 s; was the whole move shown?']
    """
    than = f"; it is nearer to {oddity.nearer}" if oddity.nearer else ""
    said = {
        "duration": f"takes {oddity.seconds:.2f} s, the others {oddity.others:.2f} s; was the whole move shown?",
        "posture": "has another posture than the others",
        "movement": f"is another movement than the others (cost {oddity.cost:.2f}){than}",
    }
    return [f"{name}: example {place} {said[difference]}" for difference in oddity.differences]
