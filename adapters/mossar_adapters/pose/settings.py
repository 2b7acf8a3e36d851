"""Settings that suit poses from pictures."""

from collections.abc import Mapping
from typing import Final

# To lie under the user's own. Measured on eight estimates of one clip of squats, level `motion`: pairs agree within 0.25 s
# with F1 0.66, without the filter 0.50. Key frames come 33 ms later (median; one picture at 30 Hz). With 1 Hz they come
# 67 ms later and agree no better. See docs/lab-notes/2026-11-webcam-jitter.md.
DEFAULTS: Final[Mapping[str, object]] = {
    "smoothing": "one_euro",
    "one_euro_cutoff": 3.0,
    "one_euro_beta": 4.0,
}
