"""Presets and levels: named sets of settings, found by evaluation on labelled recordings.

A preset is where settings start from. A level is a strength; a named level also brings a bundle of the settings
that decide what a strength means. Moving the level of a running segmenter changes the strength only; the strength
that a name stands for then depends on the bundle that the segmenter was started with.
"""

from collections.abc import Mapping

from mossar_stream.errors import SettingsError
from mossar_stream.settings import Features, LevelName, ResolvedSettings, Settings

PRESETS: dict[str, dict[str, object]] = {
    "default": {},
    # The paper's values: 1 s window, θ = 0.01, Algorithm 3 with the normalised path kernel, N = 20, L = 1.
    "paper": {
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
    },
    # For games: a short window and an early decision.
    "game": {"remerge_seconds": 1.0},
}

_MOTION: dict[str, object] = {
    "similarity": "evidence",
    "window": 0.1,
    "range_floor": 0.1 * 0.1,
    "features": Features(positions=0.5, log_speed=0.5),
    "short_segment": 0.0,
    "location": "none",
    "refine": 0.0,
    "pre_roll": 0.0,
    "post_roll": 0.0,
    "tempo": False,
    "remerge_window": 24,
    "remerge_seconds": 1.4,
}
# What level `motion` was before, and posture still is: likelihood alone.
_POSTURE: dict[str, object] = {
    "similarity": "likelihood",
    "window": 0.2,
    "features": Features(positions=0.75, log_speed=0.25),
    "short_segment": 0.0,
    "location": "free",
    "refine": 0.3,
    "pre_roll": 0.5,
    "post_roll": 0.5,
    "tempo": True,
    "remerge_window": 8,
    "remerge_seconds": 2.5,
}
_CLUSTER: dict[str, object] = {
    "similarity": "likelihood",
    "window": 0.25,
    "features": Features(distances=0.25, log_speed=0.75),
    "short_segment": 1.0,
    "location": "candidates",
    "refine": 1.0,
    "pre_roll": 0.0,
    "post_roll": 0.0,
    "tempo": False,
    "remerge_window": 8,
    "remerge_seconds": 4.5,
}
BUNDLES: dict[str, dict[str, object]] = {"motion": _MOTION, "posture": _POSTURE, "cluster": _CLUSTER}
RANGE_FLOOR_SPEED = 2.0  # m/s, mean speed of the joints below which the range does not fall

# Strengths that the names stand for, by what computes them: (similarity or kernel form, bundle).
STRENGTHS: dict[tuple[str, str], dict[LevelName, float]] = {
    ("evidence", "motion"): {"posture": 0.0, "motion": 1.0, "cluster": 4.0},
    ("evidence", "cluster"): {"posture": 0.0, "motion": 1.0, "cluster": 4.0},
    ("likelihood", "posture"): {"posture": 0.0, "motion": 0.45, "cluster": 1.0},
    ("likelihood", "cluster"): {"posture": 0.0, "motion": 0.1, "cluster": 1.25},
    ("damped", "posture"): {"posture": 0.0, "motion": 0.3, "cluster": 0.72},
    ("damped", "cluster"): {"posture": 0.0, "motion": 0.3, "cluster": 0.72},
    ("normalised", "posture"): {"posture": 0.0, "motion": 0.7, "cluster": 0.95},
    ("normalised", "cluster"): {"posture": 0.0, "motion": 0.7, "cluster": 0.95},
    ("sum", "posture"): {"posture": 0.0, "motion": 0.018, "cluster": 0.03},
    ("sum", "cluster"): {"posture": 0.0, "motion": 0.018, "cluster": 0.03},
}


def preset_values(name: str) -> Mapping[str, object]:
    """Return the fields that a preset sets.

    Raises:
        SettingsError: If there is no preset of that name.
    """
    try:
        return PRESETS[name]
    except KeyError:
        raise SettingsError(f"no preset called {name!r}; there are {', '.join(PRESETS)}") from None


def bundle_name(settings: Settings) -> str:
    """Return which bundle the level brings: the cluster's for `cluster`, else the motion's.

    Level `posture`, and whoever asks for the likelihood or for what only it can do, gets the posture's.
    """
    if settings.level == "cluster":
        return "cluster"
    if settings.similarity == "evidence":
        return "motion"
    asked = (settings.location not in (None, "none"), settings.features, settings.tempo)
    if (
        settings.similarity
        or settings.level == "posture"
        or settings.pre_roll
        or settings.post_roll
        or any(asked)
    ):
        return "posture"
    return "motion"


def bundle_values(settings: Settings) -> Mapping[str, object]:
    """Return the values of the fields that are left to the level's bundle."""
    values = dict(BUNDLES[bundle_name(settings)])
    if settings.similarity == "path_kernel" and values["location"] == "free":
        values["location"] = "none"  # moving poses between summaries needs sums that can be taken out
    window = settings.window if settings.window is not None else values["window"]
    if "range_floor" not in values:
        values["range_floor"] = RANGE_FLOOR_SPEED * float(str(window))
    return values


def level_strength(level: LevelName | float, settings: ResolvedSettings, bundle: str) -> float:
    """Return the strength that a level stands for.

    Args:
        level: A name or a strength.
        settings: Resolved settings of the segmenter.
        bundle: Name of the bundle that it was started with.
    """
    if not isinstance(level, str):
        return float(level)
    measure = settings.kernel_form if settings.similarity == "path_kernel" else settings.similarity
    return STRENGTHS[measure, bundle][level]
