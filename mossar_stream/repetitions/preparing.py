"""Preparing: constants of repetitions that follow from the skeleton, and the check of state from outside."""

import numpy as np

from mossar_stream.core.kernels import CHAINS, CYCLES
from mossar_stream.events import BODY
from mossar_stream.moves.joints import known_joints
from mossar_stream.skeleton import Skeleton

CHAIN_NAMES = (("shoulder", "elbow", "wrist"), ("hip", "knee", "ankle"), ("shoulder", "hip", "knee"))
SIDES = ("left", "right")
LEAST_SWING = 0.03  # m, rms over a limb's joints
GIVEN = ("joints", "root", "travels", "least", "chains", "chain")  # with the skeleton, for all takes
LONGEST_TAKE = 2**48  # frames; no take is as long
MOST_SAMPLES = 2**30  # of a take: the distance of two fits into 32 bits


def prepare(header: np.void, skeleton: Skeleton, channel: str) -> None:
    """Fill in the constants.

    Args:
        header: `Counting`.
        skeleton: The performer's joints.
        channel: Name of the body's channel, or of a limb's. The path of the root is part of the body's posture, not of a
            limb's. Small swings of limbs are not counted, because limbs sway with the body.
    """
    header["joints"], header["root"] = len(skeleton), max(skeleton.root, 0)
    header["travels"] = int(channel == BODY)
    header["least"] = 0.0 if channel == BODY else LEAST_SWING
    chains = chains_of(skeleton)[:CHAINS]
    header["chains"] = len(chains)
    header["chain"][: len(chains)] = np.reshape(chains, (-1, 3))


def chains_of(skeleton: Skeleton) -> list[tuple[int, int, int]]:
    """Return the joints of pairs of bones: of arms, legs and hips if their names are known, else of all joints."""
    known = known_joints(skeleton)
    named = [
        tuple(known.get(f"{side}_{joint}", -1) for joint in chain) for chain in CHAIN_NAMES for side in SIDES
    ]
    parents = skeleton.parents
    above = [(j, p, parents[p]) for j, p in enumerate(parents) if p >= 0 and parents[p] >= 0]
    return [(a, b, c) for a, b, c in named if min(a, b, c) >= 0] or above


def is_sound(header: np.void, prepared: np.void) -> bool:
    """Return whether every number that kernels use as an index or count is within its limits.

    Args:
        header: `Counting` from outside.
        prepared: `Counting` as `prepare` fills it.
    """
    same = all(np.array_equal(header[name], prepared[name]) for name in GIVEN)
    counts = [int(header[name]) for name in ("frames", "first", "fine", "analysed", "dropped", "cycles")]
    cycles = header["cycle"]
    places = np.concatenate([cycles["start"], cycles["far"], cycles["end"], cycles["count"]])
    times = [
        float(header[name])
        for name in ("origin", "latest", "wanted", "middle", "noise", "step", "quantum", "per_quantum")
    ]
    return bool(
        same
        and all(0 <= count < LONGEST_TAKE for count in counts)
        and 0 <= header["open"] < MOST_SAMPLES
        and header["cycles"] <= CYCLES
        and max(header["first"], header["analysed"]) <= header["open"]
        and (not header["begun"] or header["frames"] == 0 or header["open"] > header["first"])
        and 0 <= header["changed"] + 1 <= CYCLES + 1
        and header["clear"] in (0, 1)
        and header["begun"] in (0, 1)
        and np.isfinite(times).all()
        # s, the latest frame that was processed.
        and (not header["begun"] or abs(times[1] - times[0] - times[3]) < 1.0)
        and not np.isnan(header["due"])
        and np.isfinite(header["at"]).all()
        and np.isfinite(header["left"]).all()
        and np.all((places >= 0) & (places < MOST_SAMPLES))
        and np.all((cycles["joint"] >= 0) & (cycles["joint"] < header["joints"]))
    )
