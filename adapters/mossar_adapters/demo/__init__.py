"""The built-in performer: seeded full-body motion whose true cuts are known.

Rest, walk, punch, kick, jump, wave, squat and turn of an adult 1.70 m tall, made of minimum-jerk strokes. A sensor sees
them, with noise, jitter and losses if wanted. It serves the demo, and tests that need exact truth.

The performer moves as in an exercise class: each move is a motion in the paper's sense, an activity repeated for
two or three seconds in a posture of its own, and a brisk change of posture leads to the next. The true cuts are
the middles of these changes.

Reproducible: the same arguments give the same bytes wherever numpy's generators give the same numbers (numpy
promises that of the bit generator PCG64, and changes its distributions only with notice).

Standing still is not perfectly still: the performer breathes, about a millimetre at the head. There is no other
sway; `noise` is the sensor's alone.
"""

from mossar_adapters.demo.body import SKELETON
from mossar_adapters.demo.source import DemoSource
from mossar_adapters.demo.stream import Cut
from mossar_adapters.demo.style import Style
from mossar_adapters.demo.take import Performance, performance

__all__ = ["SKELETON", "Cut", "DemoSource", "Performance", "Style", "performance"]
