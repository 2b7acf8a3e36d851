"""Push frames as they come and print events: the core alone, no socket, no file."""

import numpy as np

from mossar_stream import KeyFrameEvent, Segmenter, SegmentEvent, Settings, Skeleton

skeleton = Skeleton(("hip", "left_hand", "right_hand"), parents=(-1, 0, 0))
segmenter = Segmenter(skeleton, Settings(level="motion"), performer="p1", fps=60)

for number in range(480):  # eight seconds: two of rest and two of swinging arms, in turns
    time = number / 60
    swing = np.sin(6 * time) if time % 4 > 2 else 0.0
    positions = np.array([[0, 1, 0], [-0.3, 1 + 0.4 * swing, 0.3], [0.3, 1 - 0.4 * swing, 0.3]])
    for event in segmenter.push(positions, time):
        if isinstance(event, KeyFrameEvent) and event.status == "confirmed":
            print(f"at {time:5.2f} s: a key frame at {event.time:5.2f} s, {event.kind}")

state = segmenter.snapshot()  # bytes; another process goes on exactly here
for event in Segmenter.restore(state).end_take():
    if isinstance(event, SegmentEvent) and event.status == "final":
        print(f"{event.start_time:5.2f} to {event.end_time:5.2f} s: {event.state}")
