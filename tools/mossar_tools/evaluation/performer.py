"""Performer: takes of the built-in performer, whose true cuts are known (`demo:`)."""

from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from mossar_adapters.address import parse_url
from mossar_adapters.demo import Performance, performance
from mossar_stream import SettingsError
from mossar_tools.evaluation.matching import Cut
from mossar_tools.evaluation.takes import Take

SEEDS = 20
TOLERANCE = 0.25  # s
# Noise like a Kinect's, at its 30 frames/s: 2 mm for the trunk at rest, more in motion and at hands and feet, with
# jumps, repeated frames and dropouts. Its quietest twentieth then has a mean joint speed of 0.20 m/s; that of the 36
# real Kinect recordings of precog_dataset_16 has 0.19 m/s.
KINDS: dict[str, dict[str, Any]] = {
    "demo, no noise": {},
    "demo, Kinect noise": {"noise": 0.002, "noise_kind": "kinect", "fps": 30.0},
}


class DemoOptions(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Options after `demo:?`; see `mossar_adapters.demo.performance`."""

    fps: float | None = None
    seconds: float | None = None
    tempo: float | None = None
    noise: float | None = None
    noise_kind: str | None = None
    jitter: float | None = None
    drop: float | None = None


def demo_takes(url: str = "demo:", seeds: int = SEEDS) -> Iterator[Take]:
    """Yield takes of the built-in performer with seeds 1 to `seeds`.

    Args:
        url: `demo:` for takes without noise and takes with a Kinect's, or with options, as in
            `demo:?fps=120&noise=0.005`.
        seeds: Number of takes of each kind.

    Raises:
        SettingsError: If an option is unknown or impossible.
    """
    options = _read_options(parse_url(url).options)
    for group, arguments in {url: options}.items() if options else KINDS.items():
        for seed in range(1, seeds + 1):
            yield _take(group, seed, performance(seed, **arguments))


def _read_options(given: Mapping[str, str]) -> dict[str, Any]:
    try:
        chosen: dict[str, Any] = msgspec.to_builtins(msgspec.convert(given, DemoOptions, strict=False))
    except msgspec.ValidationError as error:
        legal = ", ".join(DemoOptions.__struct_fields__)
        raise SettingsError(f"demo: {error}; options here are {legal}") from None
    return chosen


def _take(group: str, seed: int, shown: Performance) -> Take:
    frames = shown.frames
    if len(frames) < 2:
        raise SettingsError("demo: fewer than two frames; there is nothing to segment")
    return Take(
        name=f"{group} {seed}",
        group=group,
        level="motion",
        skeleton=shown.skeleton,
        fps=shown.fps,
        positions=frames.positions,
        times=frames.times,
        cuts=[Cut(cut.time, cut.time, cut.time) for cut in shown.cuts],
        tolerance=TOLERANCE,
    )
