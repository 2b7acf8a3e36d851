"""Presets and levels: named sets of settings, found by evaluation on labelled recordings.

A preset has the initial settings. A level is a strength; a named level also brings a bundle of the settings that give a
strength its meaning. A new level of a running segmenter changes the strength only. The name of a level whose bundle is
not in force is therefore refused (`Settings.strength`).
"""

PRESETS: dict[str, dict[str, object]] = {
    "default": {},
    # The paper's values: 1 s window, θ = 0.01, Algorithm 3 with the normalised path kernel, N = 20, L = 1.
    "paper": {
        "rate_limit": 0.0,
        "window": 1.0,
        "sig_threshold": 0.01,
        "range_floor": 0.0,
        "noise_margin": 0.0,
        "similarity": "path_kernel",
        "kernel_form": "normalised",
        "edges": 20,
        "layers": 1,
        "location": "none",
        "pre_roll": 0.0,
        "post_roll": 0.0,
        "tempo": False,
        "remerge_window": 8,
        "remerge_seconds": 2.5,
        "rests": "merge",
    },
    # For games: a short window and an early decision.
    "game": {"remerge_seconds": 1.0},
}

_MOTION: dict[str, object] = {
    "similarity": "evidence",
    "rate_limit": 30.0,
    "window": 0.1,
    "range_floor": 0.01,
    "features": {"positions": 0.5, "log_speed": 0.5},
    "short_segment": 0.0,
    "location": "none",
    "refine": 0.0,
    "pre_roll": 0.0,
    "post_roll": 0.0,
    "tempo": True,
    "remerge_window": 20,
    "remerge_seconds": 1.4,
    "rests": "keep",
}
_POSTURE: dict[str, object] = {
    "similarity": "likelihood",
    "rate_limit": 0.0,
    "window": 0.2,
    "features": {"positions": 0.75, "log_speed": 0.25},
    "short_segment": 0.0,
    "location": "free",
    "refine": 0.3,
    "pre_roll": 0.5,
    "post_roll": 0.5,
    "tempo": True,
    "remerge_window": 8,
    "remerge_seconds": 2.5,
    "rests": "merge",
}
_CLUSTER: dict[str, object] = {
    "similarity": "likelihood",
    "rate_limit": 0.0,
    "window": 0.25,
    "features": {"distances": 0.25, "log_speed": 0.75},
    "short_segment": 1.0,
    "location": "free",
    "refine": 0.4,
    "pre_roll": 0.0,
    "post_roll": 0.0,
    "tempo": False,
    "remerge_window": 8,
    "remerge_seconds": 4.4,
    "rests": "merge",
}
BUNDLES: dict[str, dict[str, object]] = {"motion": _MOTION, "posture": _POSTURE, "cluster": _CLUSTER}
RANGE_FLOOR_SPEED = 2.0  # m/s, mean speed of the joints below which the range does not fall

# Strengths of the named levels, by similarity or kernel form.
STRENGTHS: dict[str, dict[str, float]] = {
    "evidence": {"posture": 0.0, "motion": 1.0, "cluster": 4.0},
    "likelihood": {"posture": 0.0, "motion": 0.45, "cluster": 1.25},
    "damped": {"posture": 0.0, "motion": 0.3, "cluster": 0.72},
    "normalised": {"posture": 0.0, "motion": 0.7, "cluster": 0.95},
    "sum": {"posture": 0.0, "motion": 0.018, "cluster": 0.03},
}
