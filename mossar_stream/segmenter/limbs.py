"""Limbs of one performer: a channel for each, which the loop steps after that of the body."""

from mossar_stream.core.kernels import Channel
from mossar_stream.core.plan import Plan, shared_plan
from mossar_stream.core.snapshot import Following, pack_snapshot, reported_of, unpack_snapshot
from mossar_stream.errors import SnapshotError
from mossar_stream.events import BODY
from mossar_stream.moves.groups import groups_of
from mossar_stream.settings import LevelName, Settings

# A limb's take opens and ends with the body's. Limbs process the same frames as the body, after it,
# without those that come too soon for it. Their events are appended to the pending ones of the body.


def settings_of_limbs(settings: Settings) -> Settings:
    """Return the settings of limbs, given those of the body."""
    return settings.replace(limbs=False, phase=False, steps=False, center="root")


def plans_of_limbs(plan: Plan) -> list[Plan]:
    """Return the plans of the limbs in the plan of a body.

    Raises:
        FrameError: See `groups_of`.
    """
    own = settings_of_limbs(plan.user_settings)
    groups = groups_of(plan.skeleton, plan.user_settings.limbs) if plan.channel == BODY else ()
    return [shared_plan(limb.skeleton, own, plan.fps, limb.name) for limb in groups]


def bytes_with_limbs(plan: Plan) -> int:
    """Return the bytes of the rows of a body and of its limbs."""
    return plan.row_bytes + sum(limb.row_bytes for limb in plans_of_limbs(plan))


def new_limbs(plan: Plan, performer: str) -> tuple[Channel, ...]:
    """Return the limbs in the plan of a body; none if the skeleton has none."""
    return tuple(Channel(limb, performer, limb.new_row()) for limb in plans_of_limbs(plan))


def joints_of_limbs(plan: Plan) -> tuple[tuple[int, ...], ...]:
    """Return the joints of each limb, as indices of the performer's."""
    return tuple(limb.joints for limb in groups_of(plan.skeleton, plan.user_settings.limbs))


def pack_limb(limb: Channel, level: LevelName | float) -> bytes:
    """Return the state of a limb."""
    return pack_snapshot(
        limb.plan, limb.performer, level, [], limb.memory, Following(repetitions=reported_of(limb))
    )


def restored_limbs(plan: Plan, performer: str, blobs: tuple[bytes, ...]) -> tuple[Channel, ...]:
    """Return the limbs of a snapshot, one for each limb in the plan of the body.

    Raises:
        SnapshotError: If they are damaged, or belong to other limbs.
    """
    plans = plans_of_limbs(plan)
    if plans and len(blobs) != len(plans):
        raise SnapshotError("the snapshot's limbs are not those of its settings")
    found = []
    for wanted, blob in zip(plans, blobs, strict=False):
        own, name, _, _, content, _, known = unpack_snapshot(blob, channel=wanted.channel)
        same = (own.skeleton, name, own.user_settings) == (wanted.skeleton, performer, wanted.user_settings)
        if not same or known.limbs:
            raise SnapshotError("the snapshot's limbs are not those of its settings")
        limb = Channel(own, performer, content)
        known.give_repetitions(limb)
        found.append(limb)
    return tuple(found)
