"""Plan: what a performer needs, as follows from skeleton, settings and rate."""

import math
from functools import cached_property, lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import (
    BOUTS,
    LABELLED_LATE,
    MARGIN,
    NOTED_CANDIDATES,
    NOTED_LATE,
    SPACING,
    SPARE_SUMMARIES,
    SPEED_WINDOW,
    TIME_ROUNDING,
    pad,
)
from mossar_stream.core.out import Source
from mossar_stream.core.row import PLAN, REGIONS, Shape, new_memory, records, region
from mossar_stream.errors import SettingsError
from mossar_stream.events import BODY, Event
from mossar_stream.moves.groups import groups_of, leading_limb, limbs_by_joint
from mossar_stream.moves.joints import details
from mossar_stream.repetitions.preparing import prepare as prepare_counting
from mossar_stream.settings import LevelName, Settings
from mossar_stream.similarity import protocol as similarity
from mossar_stream.skeleton import Skeleton

# In the order of the numbers that the compiled core knows them by.
SMOOTHINGS = ("none", "moving_average", "one_euro")
POLICIES = ("running", "fixed", "decay")
LOCATIONS = ("none", "free", "candidates")
FIRST_ROOM, MORE_ROOM = 8, 4  # undecided key frames that a row has room for at first, and that it grows by
BOUNDLESS = np.iinfo(np.int64).max
ASSUMED_FPS = 256.0  # Hz, for the velocity ring where the rate is unknown; the ring grows if need be
LONGEST_HISTORY = 30.0  # s
KNOWN_LEADERS = 256  # sets of joints whose limb is remembered
# Minimum interval of processed frames, as a share of 1 / rate_limit: frames come with jitter.
LEAST_INTERVAL = 0.8
FRAMES_OF_GAP = 1.5  # a step in time is no gap if it is shorter, at the nominal rate


class Plan:
    """How rows are laid out and filled in: follows from skeleton, settings and rate.

    Args:
        skeleton: Joints.
        settings: As the user gave them.
        fps: Nominal rate, Hz, or None.
        ring: Places in the velocity ring; None to follow from the rate.
        channel: The body's, or of a limb.
        offline: Whether every key frame is kept until the take ends.
        window: Key frames there is room for, if not the setting.
        room: Undecided key frames whose segments there are slots for; None for as many as a row begins with.
        history: Poses kept, if not what the settings call for.
        bouts: Bouts of movement kept, if not those of a stream.
    """

    def __init__(
        self,
        skeleton: Skeleton,
        settings: Settings,
        fps: float | None = None,
        ring: int | None = None,
        *,
        channel: str = BODY,
        window: int | None = None,
        room: int | None = None,
        history: int | None = None,
        bouts: int = BOUTS,
        offline: bool = False,
    ) -> None:
        self.skeleton = skeleton
        self.user_settings = settings
        self.settings = resolved = settings.resolved()
        if resolved.range == "file":
            raise SettingsError(
                "setting range=file needs a whole recording: use mossar segment, or range=running here"
            )
        self.fps = fps
        self.channel = channel
        self.offline = offline
        self.center = skeleton.root if resolved.center == "root" else -1
        joints = len(skeleton)
        padded = pad(joints)
        self.params = similarity.make_params(resolved, joints, padded, self.center)
        self.traits = similarity.traits(resolved)
        has_features = self.traits.has_features
        kept = (
            resolved.refine + min(resolved.remerge_seconds, LONGEST_HISTORY)
            if resolved.location == "free"
            else 0.0
        )
        most = window or resolved.remerge_window
        self.shape = Shape(
            joints=joints,
            ring=ring or math.ceil(resolved.window * min(max(fps or ASSUMED_FPS, 1.0), self.most_rate)) + 8,
            slot=similarity.slot_size(resolved, self.params),
            window=most,
            room=most if offline else min(max(room or 0, FIRST_ROOM), most),
            smoothing_window=resolved.smoothing_window if resolved.smoothing == "moving_average" else 0,
            one_euro=resolved.smoothing == "one_euro",
            history=history or history_size(kept),
            bouts=bouts,
            counted=not offline,
            features=has_features,
            notes=(NOTED_LATE if self._labels_late else NOTED_CANDIDATES) * has_features,
            repetitions=resolved.repetitions or (has_features and channel == BODY),
            adopts=has_features and channel != BODY,
        )

    @property
    def spacing(self) -> float:
        """Minimum interval of processed frames, s; the others are skipped."""
        limit = self.settings.rate_limit
        return LEAST_INTERVAL / limit - MARGIN if limit > 0.0 else 0.0

    @property
    def most_rate(self) -> float:
        """Highest rate of processed frames, Hz."""
        return 1.0 / self.spacing if self.spacing > 0.0 else math.inf

    @cached_property
    def row_bytes(self) -> int:
        """Length of a row."""
        return self.shape.offsets()[1]

    @property
    def most_events(self) -> int:
        """Most events that one frame, or the end of a take, can cause."""
        return 8 * self.shape.window + 32

    @property
    def _labels_late(self) -> bool:
        """Whether labels wait for what is counted: in recordings, and in streams that decide as late."""
        chosen = self.settings
        waits = chosen.remerge_seconds > LABELLED_LATE and chosen.remerge_window >= NOTED_LATE
        return self.offline or waits

    @property
    def _most_undecided(self) -> int:
        """Undecided key frames with which a row can take the next frame, which may bring one more."""
        if self.offline:
            return self.shape.window - 1
        return self.shape.room if self.shape.room < self.shape.window else BOUNDLESS

    def source(self, performer: str, pending: list[Event]) -> Source:
        """Return whose the events of a performer's row are, and where they wait."""
        names = self.skeleton.names
        by_joint = limbs_by_joint(groups_of(self.skeleton, self.user_settings.limbs))
        if not by_joint:
            return Source(performer, self.channel, names, pending)
        # The same joints lead again and again, and a segment is reported several times.
        leading = lru_cache(KNOWN_LEADERS)(partial(leading_limb, by_joint=by_joint))
        return Source(performer, self.channel, names, pending, tuple(map(by_joint.get, names)), leading)

    def strength(self, level: LevelName | float) -> float:
        """Return the strength that a level stands for with these settings."""
        return self.user_settings.strength(level)

    def continues(self, other: "Plan") -> bool:
        """Tell whether a row of `other` can go on with this plan: the same curve, summaries and tempo."""
        mine, theirs = self.settings, other.settings
        return (
            self.shape == other.shape
            and self.params.tobytes() == other.params.tobytes()
            and self.center == other.center
            and (mine.window, mine.smoothing, mine.range, mine.tempo)
            == (theirs.window, theirs.smoothing, theirs.range, theirs.tempo)
            and mine.rate_limit == theirs.rate_limit
            and mine.repetitions == theirs.repetitions
            # Limbs that come back would number their repetitions from 1 again.
            and (mine.limbs == theirs.limbs or not mine.repetitions)
        )

    def _values(self) -> dict[str, float]:
        """Return what PLAN holds."""
        shape, chosen = self.shape, self.settings
        moving = max(1, shape.joints - 1 if self.center >= 0 else shape.joints)
        noisy = chosen.sig_threshold > 0 and chosen.range != "fixed"
        return {
            "joints": shape.joints,
            "padded_joints": shape.padded_joints,
            "center": self.center,
            "flat": similarity.takes_pose(chosen, self.params),
            "moving_joints": moving,
            "filtered_joints": shape.padded_joints * shape.one_euro,
            "average_size": shape.smoothing_window,
            "ring": shape.ring,
            "slot": shape.slot,
            "slot_count": shape.slots,
            "memo_size": shape.memo,
            "history_size": shape.history,
            "bouts": shape.bouts,
            "notes": shape.notes,
            "samples": shape.region_sizes()["samples"],
            "capacity": shape.window,
            "room": self._most_undecided,
            "most_events": self.most_events,
            "window": chosen.window,
            "smoothing": SMOOTHINGS.index(chosen.smoothing),
            "one_euro_cutoff": chosen.one_euro_cutoff,
            "one_euro_beta": chosen.one_euro_beta,
            "theta": chosen.sig_threshold,
            "rest_seconds": chosen.rest_seconds,
            "rests": chosen.rests == "keep",
            "range_policy": POLICIES.index(chosen.range),
            "range_min": chosen.range_min,
            "range_max": chosen.range_max or 0.0,
            "range_half_life": chosen.range_half_life,
            "range_floor": chosen.range_floor * moving,
            "noise_margin": chosen.noise_margin if noisy else 0.0,
            "spacing": self.spacing,
            # A source of few frames per second has no gaps for that.
            "max_gap": max(chosen.max_gap, FRAMES_OF_GAP / self.fps if self.fps else 0.0) + TIME_ROUNDING,
            "max_speed": chosen.max_speed,
            "max_pause": math.inf if self.offline else chosen.max_pause + TIME_ROUNDING,
            "hold": chosen.remerge_seconds - TIME_ROUNDING,
            "alpha": 0,
            "beta": self.strength(chosen.level),
            "location": LOCATIONS.index(chosen.location),
            "refine": chosen.refine,
            "pre_roll": chosen.pre_roll,
            "post_roll": chosen.post_roll,
            "tempo": chosen.tempo and not shape.features,
            "own_time": chosen.tempo and shape.features,
            **self.traits._asdict(),
            "repetitions": shape.repetitions,
            "details": details(self.skeleton),
            "ends_alone": self.channel == BODY and not self.offline,
            "adopts": shape.adopts,
            "labels_late": self._labels_late,
            "offline": self.offline,
        }

    def prepare(self, row: NDArray[np.uint8], number: int) -> None:
        """Fill in the part of a row that does not change while frames come in.

        Args:
            row: Bytes of the row; zeros, or a row of the same plan.
            number: That its events carry.
        """
        state = records(row)
        state["clock"]["row"] = number
        values = self._values()
        for name in PLAN.names or ():
            state["plan"][name] = values[name]
        for name, offset in self.shape.offsets()[0].items():
            state["at"][name] = offset
        for header in region(row, self.shape, "counted"):
            prepare_counting(header, self.skeleton, self.channel)

    def new_memory(self, count: int) -> NDArray[np.uint8]:
        """Return memory for so many rows, (count, row_bytes), not prepared."""
        return new_memory(count, self.row_bytes)

    def new_rows(self, count: int) -> NDArray[np.uint8]:
        """Return prepared rows, (count, row_bytes)."""
        rows = self.new_memory(count)
        for index, row in enumerate(rows):
            self.prepare(row, index)
        return rows

    def with_settings(self, settings: Settings) -> "Plan":
        """Return the plan for other settings of a stream, with the room that its row has."""
        shape = self.shape
        return Plan(self.skeleton, settings, self.fps, shape.ring, channel=self.channel, room=shape.room)

    @cached_property
    def with_longer_ring(self) -> "Plan":
        """The same plan with twice the places in the velocity ring."""
        return self._larger(ring=2 * self.shape.ring)

    @cached_property
    def with_more_room(self) -> "Plan":
        """The same plan with room for more undecided key frames: up to W in a stream, for twice W in a recording."""
        if self.offline:
            return self._larger(window=2 * self.shape.window)
        return self._larger(room=self.shape.room + MORE_ROOM)

    def _larger(self, **changed: int) -> "Plan":
        sizes = {name: getattr(self.shape, name) for name in ("ring", "window", "room", "history", "bouts")}
        return Plan(
            self.skeleton,
            self.user_settings,
            self.fps,
            channel=self.channel,
            offline=self.offline,
            **(sizes | changed),
        )


def history_size(seconds: float) -> int:
    """Return how many poses cover `seconds`, with the speed window before them."""
    return int((seconds + SPEED_WINDOW + 2 * SPACING) / SPACING) + 4


def move_row(old: NDArray[np.uint8], before: Plan, new: NDArray[np.uint8], after: Plan) -> None:
    """Copy a performer's state into a row with more room.

    Args:
        old: The row so far.
        before: Its plan.
        new: The row from now on, prepared.
        after: Its plan.
    """
    was, now = records(old), records(new)
    index = int(now["clock"]["row"])
    for name in was.dtype.names:
        if name not in ("plan", "at"):
            now[name] = was[name]
    now["clock"]["row"] = index
    now["plan"]["alpha"], now["plan"]["beta"] = was["plan"]["alpha"], was["plan"]["beta"]
    velocity, slots = now["velocity"], now["slots"]
    tail = (int(velocity["head"]) - int(velocity["filled"])) % before.shape.ring
    for name, _ in REGIONS:
        source, target = region(old, before.shape, name), region(new, after.shape, name)
        if name.startswith("ring_"):
            source = np.roll(source, -tail)
        if name != "memo" or len(source) == len(target):  # its places follow from its size
            target[: len(source)] = source
    velocity["head"] = velocity["filled"]
    added = np.arange(before.shape.slots, after.shape.slots)
    region(new, after.shape, "unused")[int(slots["unused_count"]) :][: len(added)] = added
    slots["unused_count"] += len(added)


def new_scratch(shape: Shape) -> NDArray[np.uint8]:
    """Return the bytes of a `Scratch` of window.pxi, shared by all rows of a shape."""
    window, slot, joints = shape.window, shape.slot, shape.padded_joints
    numbers = (window + SPARE_SUMMARIES) * slot + 2 * joints + 12 * (window + 4)
    return np.zeros(8 * numbers, np.uint8)
