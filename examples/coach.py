"""A coach: one repetition of an exercise is the example; all others are counted, followed and judged as they come.

`python examples/coach.py squats.bvh 3.4 4.6`: the example is the part of the recording from 3.4 s to 4.6 s, and the recording is
pushed frame by frame, as a sensor would. Replace the loop over frames by your sensor's.
"""

import sys

from mossar_adapters.files import read
from mossar_stream import FollowEvent, Moves, Segmenter

STRAYS = 10.0  # degrees of deviation from which a limb is named


def said(event: FollowEvent) -> str:
    """Return a coach's line about a performance: its count, a correction, and its score."""
    angle = event.limbs.get(event.limb, event.deviation)  # of the body where no limb can be judged
    mind = (
        f"mind the {event.limb.replace('_', ' ')}, {angle:.0f} degrees off" if angle > STRAYS else "well done"
    )
    shallow = [name.replace("_", " ") for name, share in (event.range or {}).items() if share < 0.8]
    depth = f", farther with the {' and the '.join(shallow)}" if shallow else ""
    tempo = "slower, please" if event.tempo > 1.3 else "faster, please" if event.tempo < 0.7 else "good tempo"
    return f"{event.count}: {mind}{depth}, {tempo}, score {event.score:.2f}"


def main() -> None:
    """Teach the example, then follow the whole recording."""
    take, start, end = read(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3])
    shown = (take.times >= start) & (take.times <= end)
    moves = Moves(take.skeleton)
    moves.add("exercise", take.positions[shown], fps=(shown.sum() - 1) / (end - start))
    segmenter = Segmenter(take.skeleton, moves=moves, follow=True)
    for positions, time in zip(take.positions, take.times, strict=True):
        for event in segmenter.push(positions, float(time)):
            if isinstance(event, FollowEvent) and event.status == "done":
                print(said(event), flush=True)
        now = segmenter.following["exercise"]  # None while it is not being made
        if now is not None and sys.stdout.isatty():
            print(f"{now.progress:4.0%}", end="\r", flush=True)


main()
