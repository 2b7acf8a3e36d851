"""The dashboard shows how often a movement was repeated."""

import numpy as np

from mossar_stream import Frames, RepetitionEvent, Segmenter, Settings, Skeleton
from mossar_tools.dashboard.tables import state_card
from mossar_tools.dashboard.track import Track


def test_the_count_and_the_tempo_of_repetitions_are_shown_large():
    settings = Settings(repetitions=True)
    skeleton = Skeleton(("hips", "hand"), (-1, 0))
    segmenter, track = Segmenter(skeleton, settings), Track("p1", skeleton)
    times = np.arange(300) / 30
    positions = np.zeros((300, 2, 3), np.float32)
    positions[:, 1, 1] = 0.5 - 0.5 * np.cos(2 * np.pi * times / 1.5)
    said = []
    for i in range(300):
        for event in segmenter.push(positions[i], float(times[i])):
            track.add_event(event)
            said += [event] if isinstance(event, RepetitionEvent) else []
        track.add_sample(segmenter.state)
    track.add_frames(Frames(positions, times, performer="p1"))
    glimpse = track.glimpse(1.0, [])
    assert (glimpse.repeated.total, glimpse.repeated.tempo) == (said[-1].total, said[-1].tempo)
    card = state_card([glimpse], frozen=False, recording="", frames=0)
    assert f'<span class="count">{said[-1].total}<' in card
    assert f'<span class="count">{said[-1].tempo:.0f}<' in card
    for event in segmenter.reset():
        track.add_event(event)
    for event in segmenter.push(positions[0], 20.0):
        track.add_event(event)
    assert track.glimpse(1.0, []).repeated is None
