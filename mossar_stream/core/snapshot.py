"""Snapshot: the state of a segmenter, as bytes.

Magic, version, SHA-256 of the rest, then a msgpack map: settings, skeleton and rate, from which the layout of the
row follows, and the row itself. No pickle; damaged bytes are refused before they are decoded.
"""

import hashlib
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import CYCLES, Channel
from mossar_stream.core.plan import Plan
from mossar_stream.core.row import records
from mossar_stream.core.validation import is_sound
from mossar_stream.errors import FrameError, MovesError, SettingsError, SnapshotError
from mossar_stream.events import BODY, Event
from mossar_stream.following.alignment import Alignment, Follow, alignment_of
from mossar_stream.frames import constant_times, performer_name
from mossar_stream.moves.groups import groups_of
from mossar_stream.moves.moves import Moves
from mossar_stream.moves.recognition import Recognition
from mossar_stream.repetitions.reporting import Reported
from mossar_stream.settings import LevelName, Settings
from mossar_stream.skeleton import Skeleton

MAGIC = b"MOSSAR\x00"
SNAPSHOT_VERSION = 35  # raised whenever the layout of rows, or the meaning of their numbers, changes
HEADER_BYTES = len(MAGIC) + 1 + 32


Number = Annotated[int, msgspec.Meta(ge=0, lt=1 << 60)]


class Numbers(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Numbers of the last events, also while their reporter is switched off.

    Args:
        moves: Of the latest recognised move.
        performances: Of the latest performance of a followed move in this take.
        counts: How many performances of each followed move are done in this take.
        poses: Of the latest held pose in this take.
        steps: Of the latest step in this take.
    """

    moves: Number = 0
    performances: Number = 0
    counts: dict[str, Number] = {}
    poses: Number = 0
    steps: Number = 0


class Following(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """State of all readers of the frames, besides the segmentation of the body.

    Args:
        moves: As a file of moves has them; None if none are recognised, or they are kept elsewhere.
        digest: Of the moves.
        recognition: State of their recognition; None without moves.
        repetitions: State of their events, with the setting.
        limbs: A snapshot of each limb, in their order.
        steps: State of the feet; None if steps are not reported.
        follow: Moves to follow.
        followed: Their state; None if none are.
        poses: State of held poses; None if none are recognised.
        numbers: Numbers of the last events.
    """

    moves: bytes | None = None
    digest: bytes = b""
    recognition: bytes | None = None
    repetitions: Reported | None = None
    limbs: tuple[bytes, ...] = ()
    steps: bytes | None = None
    follow: bool | tuple[str, ...] = ()
    followed: bytes | None = None
    poses: bytes | None = None
    numbers: Numbers = Numbers()

    def give_repetitions(self, channel: Channel) -> None:
        """Continue the reported repetitions of the body or a limb, if a take is open.

        Raises:
            SnapshotError: If it does not fit the counted repetitions.
        """
        if not channel.plan.reports_repetitions or not channel.is_open:
            return
        known = self.repetitions
        if known is None or not 0 <= known.total <= channel.repetitions or len(known.revisions) > 2 * CYCLES:
            raise SnapshotError("the snapshot's repetitions contradict themselves")
        channel.go_on_from(known.total, known.revisions, known.phase)


def reported_of(channel: Channel) -> Reported | None:
    """Return the reported repetitions of the body or a limb; None if none are reported."""
    return Reported(*channel.reported) if channel.plan.reports_repetitions else None


class _Content(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    settings: Settings
    skeleton: Skeleton
    fps: float | None
    ring: Annotated[int, msgspec.Meta(ge=1)]
    room: Annotated[int, msgspec.Meta(ge=1)]
    performer: str
    level: LevelName | float
    pending: list[Event]
    row: bytes
    following: Following


def pack_snapshot(
    plan: Plan,
    performer: str,
    level: LevelName | float,
    pending: list[Event],
    row: NDArray[np.uint8],
    following: Following,
) -> bytes:
    """Return a snapshot of a performer.

    Args:
        plan: Of the row.
        performer: Name.
        level: As it is now.
        pending: Events that have not been handed out.
        row: Bytes of the performer.
        following: State of moves, repetitions and limbs.
    """
    content = _Content(
        plan.user_settings,
        plan.skeleton,
        plan.fps,
        *plan.sizes[:2],
        performer,
        level,
        pending,
        row.tobytes(),
        following,
    )
    body = msgspec.msgpack.encode(content)
    return MAGIC + bytes([SNAPSHOT_VERSION]) + hashlib.sha256(body).digest() + body


def unpack_snapshot(
    blob: bytes, moves: Moves | None = None, channel: str = BODY, *, with_moves: bool = True
) -> tuple[Plan, str, LevelName | float, list[Event], NDArray[np.uint8], Recognition | None, Following]:
    """Return plan, performer, level, pending events, row, recognition and the other readers of a snapshot.

    Args:
        blob: The snapshot.
        moves: For one that was made without them.
        channel: The body's, or of a limb.
        with_moves: Whether moves are recognised from now on, if they were before.

    Raises:
        SnapshotError: If the bytes are damaged, truncated, of a newer version, or made to do harm.
    """
    if len(blob) < HEADER_BYTES or not blob.startswith(MAGIC):
        raise SnapshotError("these bytes are not a snapshot, or the beginning of one is missing")
    version, digest, body = blob[len(MAGIC)], blob[len(MAGIC) + 1 : HEADER_BYTES], blob[HEADER_BYTES:]
    if version != SNAPSHOT_VERSION:
        raise SnapshotError(
            f"the snapshot has version {version}; this program reads version {SNAPSHOT_VERSION}"
        )
    if hashlib.sha256(body).digest() != digest:
        raise SnapshotError("the snapshot is damaged or truncated: its checksum does not fit")
    try:
        content = msgspec.msgpack.decode(body, type=_Content)
        plan = Plan(
            content.skeleton,
            content.settings,
            content.fps,
            content.ring,
            channel=channel,
            room=content.room,
        )
        if content.fps is not None:
            constant_times(0, content.fps)
        level = plan.strength(content.settings.replace(level=content.level).level)
        groups_of(content.skeleton, content.settings.limbs)
    except (msgspec.MsgspecError, FrameError, SettingsError, ValueError) as error:
        raise SnapshotError(f"the snapshot cannot be read: {error}") from None
    if len(content.row) != plan.row_bytes:
        raise SnapshotError(
            f"the snapshot's state has {len(content.row)} bytes; its settings call for {plan.row_bytes}"
        )
    row = plan.new_row()
    row[:] = np.frombuffer(content.row, np.uint8)
    plan.prepare(row)
    records(row)["plan"]["beta"] = level
    if not is_sound(row, plan):
        raise SnapshotError("the snapshot's state contradicts itself")
    name = performer_name(content.performer)
    recognition = _recognition(content, name, moves) if with_moves else None
    return plan, name, content.level, content.pending, row, recognition, content.following


def _recognition(content: _Content, performer: str, moves: Moves | None) -> Recognition | None:
    known = content.following
    if known.recognition is None:
        return None
    try:
        own = moves if known.moves is None else Moves.from_json(known.moves)
        if own is None:
            raise SnapshotError("the snapshot was made without its moves; restore needs them")
        recognition = Recognition(own, content.skeleton, performer)
    except (MovesError, FrameError) as error:
        raise SnapshotError(f"the snapshot's moves cannot be read: {error}") from None
    if known.moves is None and known.digest != recognition.digest:
        recognition.count_on_from(known.numbers.moves)
    else:
        recognition.go_on_from(known.recognition)
    return recognition


def restored_following(
    known: Following, recognition: Recognition | None, follow: Follow | None, plan: Plan, performer: str
) -> tuple[Follow, Alignment | None]:
    """Return the followed moves of a snapshot, and their alignment.

    Args:
        known: Of `unpack_snapshot`.
        recognition: The same.
        follow: Moves to follow from now on; None as before.
        plan: Of the row.
        performer: Name.

    Raises:
        SnapshotError: If it is damaged.
    """
    chosen = known.follow if follow is None else follow
    if recognition is None:
        return chosen, None
    try:
        alignment = alignment_of(chosen, recognition.moves, plan.skeleton, plan.user_settings, performer)
    except MovesError as error:
        raise SnapshotError(f"the snapshot's moves cannot be followed: {error}") from None
    if alignment is not None and known.followed is not None:
        if known.digest == recognition.digest and chosen == known.follow:
            alignment.go_on_from(known.followed)
        else:
            alignment.count_on_from(known.numbers.performances, known.numbers.counts)
    return chosen, alignment
