"""Settings guide: what each setting is measured in, and what happens when it is moved."""

from typing import Final, NamedTuple


class Guide(NamedTuple):
    """What a user needs to know of a setting.

    Args:
        unit: Of its value; empty where it has none.
        effect: What a larger value does, or what the choices mean.
    """

    unit: str
    effect: str


SETTINGS_GUIDE: Final[dict[str, Guide]] = {
    "level": Guide(
        "",
        "posture keeps every key frame, motion single moves, cluster activities; a number is a strength, larger keeps fewer",
    ),
    "rate_limit": Guide(
        "Hz", "lower: fewer frames are looked at, the others are passed over; 0 takes all in"
    ),
    "window": Guide("s", "longer: a smoother velocity, fewer key frames, each later"),
    "smoothing": Guide(
        "", "none, moving_average of the velocity (the paper's), one_euro filter on the joints"
    ),
    "smoothing_window": Guide("frames", "longer: smoother, later; for smoothing=moving_average"),
    "one_euro_cutoff": Guide("Hz", "smaller: less jitter, more lag; for smoothing=one_euro"),
    "one_euro_beta": Guide("Hz per m/s", "larger: less lag in quick moves; for smoothing=one_euro"),
    "sig_threshold": Guide(
        "of the range", "larger: fewer onsets, offsets and minima; small moves are missed"
    ),
    "range": Guide(
        "",
        "running: the largest velocity so far; decay: forgets it slowly; fixed: range_min to range_max; file: offline",
    ),
    "range_min": Guide(
        "m", "for range=fixed: the summed path of all joints within the window that counts as 0"
    ),
    "range_max": Guide("m", "for range=fixed: that which counts as 1; larger: fewer key frames"),
    "range_half_life": Guide(
        "s", "for range=decay; shorter: quiet moves count again sooner after a wild one"
    ),
    "range_floor": Guide("m per joint", "larger: somebody who hardly moves causes fewer key frames"),
    "noise_margin": Guide("", "larger: a trembling sensor causes fewer key frames; 0 is off"),
    "center": Guide(
        "", "root: moves are seen relative to the root joint; centroid: to the mean of the joints"
    ),
    "similarity": Guide(
        "",
        "evidence: odds of a change, a stop, a rest; likelihood: whether one pose distribution explains both sides; path_kernel: the paper's",
    ),
    "features": Guide(
        "weights", "what likelihood looks at: positions, distances between joints, log_speed of joints"
    ),
    "variance_floor": Guide("m², m², 1", "larger: small differences of poses count less, more is merged"),
    "edges": Guide("", "N of the path kernel; more: finer and slower"),
    "layers": Guide("", "L of the path kernel's pyramid; more: the order of poses counts"),
    "kernel_form": Guide("", "damped (ours), sum or normalised (the paper's)"),
    "short_segment": Guide("s", "longer: short segments are merged sooner; 0 is off"),
    "location": Guide("", "whether a final key frame may move to a likelier place: none, free, candidates"),
    "refine": Guide("s", "how far it may move"),
    "pre_roll": Guide(
        "s", "how long the first posture is taken to have been held; longer: the first onset is stronger"
    ),
    "post_roll": Guide("s", "the same for the last posture of a take"),
    "tempo": Guide("", "true: slow performers keep as many key frames as quick ones"),
    "max_key_frames": Guide(
        "", "offline: at least so many key frames stand, the strongest, whatever the level says"
    ),
    "remerge_window": Guide(
        "key frames", "more: later context decides, final comes later; work and memory grow"
    ),
    "remerge_seconds": Guide("s", "longer: final is surer and comes later"),
    "max_gap": Guide("s", "longer: a missing joint is held longer before it is left out"),
    "max_speed": Guide("m/s", "smaller: more of a quick move is taken for an outlier"),
    "max_pause": Guide("s", "longer: a take survives longer pauses of its sender"),
    "rest_seconds": Guide(
        "s", "longer: `resting` is reported later, and shorter rests are part of the movement"
    ),
    "rests": Guide(
        "",
        "keep: holds and rests of 0.6 s and more are segments of their own; merge: the level alone decides",
    ),
    "repetitions": Guide("", "true: counts how often movements are repeated, and how fast"),
    "phase": Guide("", "true: with repetitions, tells of each frame where in the cycle it is"),
    "limbs": Guide(
        "",
        "true: arms, legs and trunk have key frames of their own; or NAME=JOINT,...;...",
    ),
    "steps": Guide("", "true: reports when feet leave the ground and come down"),
    "feet": Guide("", "for steps: left=JOINT,... right=JOINT,...; empty: those known by name"),
    "step_sensitivity": Guide("", "larger: smaller and slower movements of a foot are steps"),
    "up": Guide(
        "", "the axis that points upwards, as y or -z; auto: for steps from the feet to the head, else y"
    ),
    "follow_every": Guide("s", "time between two progress events of a move that is followed"),
}
