"""Plan: the sizes and constants of a performer, by skeleton, settings and rate."""

import math
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import (
    BOUTS,
    LABELLED_LATE,
    MARGIN,
    NOTED_CANDIDATES,
    NOTED_LATE,
    RECORDS,
    SPACING,
    SPEED_WINDOW,
    TIME_ROUNDING,
    lay_out,
    new_row,
    pad,
    row_bytes,
)
from mossar_stream.core.row import region
from mossar_stream.errors import SettingsError
from mossar_stream.events import BODY
from mossar_stream.moves.groups import groups_of, limbs_by_joint
from mossar_stream.moves.joints import details
from mossar_stream.repetitions.preparing import prepare as prepare_counting
from mossar_stream.settings import LevelName, Settings
from mossar_stream.similarity import protocol as similarity
from mossar_stream.skeleton import Skeleton

# In the order of the numbers that the compiled core knows them by.
SMOOTHINGS = ("none", "moving_average", "one_euro")
POLICIES = ("running", "fixed", "decay")
LOCATIONS = ("none", "free", "candidates")
PLAN = RECORDS["Plan"]
FIRST_ROOM = 8  # undecided key frames that a row has room for at first
KNOWN = 64  # plans that are shared
ASSUMED_FPS = 256.0  # Hz, for the velocity ring where the rate is unknown; the ring grows if need be
LONGEST_HISTORY = 30.0  # s
# Minimum interval of processed frames, as a share of 1 / rate_limit: frames come with jitter.
LEAST_INTERVAL = 0.8
# Members of a plan that decide the layout of a row, except the sizes that it may outgrow.
SIZES = (
    "joints", "slot", "capacity", "average_size", "filtered_joints", "history_size", "bouts", "offline", "has_features", "notes",
    "repetitions", "adopts",
)  # fmt: skip
FRAMES_OF_GAP = 1.5  # a step in time is no gap if it is shorter, at the nominal rate


class Plan:
    """Layout and constants of rows, from skeleton, settings and rate.

    Args:
        skeleton: Joints.
        settings: As the user gave them.
        fps: Nominal rate, Hz, or None.
        ring: Places in the velocity ring; None to follow from the rate.
        channel: The body's, or of a limb.
        offline: Whether every key frame is kept until the take ends.
        window: Key frames there is room for, if not the setting.
        room: Undecided key frames whose segments there are slots for; None for as many as a row begins with.
        history: Number of kept poses, if not that of the settings.
        bouts: Bouts of movement kept, if not those of a stream.

    Attributes:
        params: (1,) Measure, parameters of the similarity.
        record: (1,) Plan, the plan as the compiled core reads it.
        joint_names: Of the skeleton.
        reports_repetitions: Whether events of repetitions are wanted.
        sizes: Places in the velocity ring, room, and key frames there is room for at most: those a row may outgrow.
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
        self.fps = None if fps is None else float(fps)
        self.channel = channel
        self.offline = offline
        self.center = skeleton.root if resolved.center == "root" else -1
        joints = len(skeleton)
        self.params = similarity.make_params(resolved, joints, pad(joints), self.center)
        self.traits = similarity.traits(resolved)
        kept = (
            resolved.refine + min(resolved.remerge_seconds, LONGEST_HISTORY)
            if resolved.location == "free"
            else 0.0
        )
        most = window or resolved.remerge_window
        self.sizes = (
            ring or math.ceil(resolved.window * min(max(fps or ASSUMED_FPS, 1.0), self.most_rate)) + 8,
            most if offline else min(max(room or 0, FIRST_ROOM), most),
            most,
        )
        self._kept = history or history_size(kept), bouts
        self.joint_names = skeleton.names
        self.reports_repetitions = settings.repetitions
        self.record = np.zeros(1, PLAN)
        for name, value in self._values().items():
            self.record[name] = value

    @cached_property
    def joint_limbs(self) -> tuple[str | None, ...]:
        """Of each joint the limb that it belongs to, or None; empty without the setting `limbs`.

        Raises:
            FrameError: See `groups_of`.
        """
        by_joint = limbs_by_joint(groups_of(self.skeleton, self.user_settings.limbs))
        return tuple(map(by_joint.get, self.joint_names)) if by_joint else ()

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
        return row_bytes(self.record)

    @property
    def _labels_late(self) -> bool:
        """Whether labels wait for counted repetitions: in recordings, and in streams that decide as late."""
        chosen = self.settings
        waits = chosen.remerge_seconds > LABELLED_LATE and chosen.remerge_window >= NOTED_LATE
        return self.offline or waits

    def strength(self, level: LevelName | float) -> float:
        """Return the strength that a level stands for with these settings."""
        return self.user_settings.strength(level)

    def continues(self, other: "Plan") -> bool:
        """Return whether a row of `other` can go on with this plan: the same curve, summaries and tempo."""
        mine, theirs = self.settings, other.settings
        return (
            all(self.record[name] == other.record[name] for name in SIZES)
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
        """Return the values of PLAN, but for sizes that follow from others."""
        chosen, traits = self.settings, self.traits
        joints, features, is_body = len(self.skeleton), traits.has_features, self.channel == BODY
        moving = max(1, joints - 1 if self.center >= 0 else joints)
        noisy = chosen.sig_threshold > 0 and chosen.range != "fixed"
        ring, room, most = self.sizes
        history, bouts = self._kept
        return {
            "joints": joints,
            "center": self.center,
            "flat": similarity.takes_pose(chosen, self.params),
            "moving_joints": moving,
            "filtered_joints": pad(joints) * (chosen.smoothing == "one_euro"),
            "average_size": chosen.smoothing_window if chosen.smoothing == "moving_average" else 0,
            "ring": ring,
            "slot": similarity.slot_size(chosen, self.params),
            "history_size": history,
            "bouts": bouts,
            "notes": (NOTED_LATE if self._labels_late else NOTED_CANDIDATES) * features,
            "capacity": most,
            "room": room,
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
            "tempo": chosen.tempo and not features,
            "own_time": chosen.tempo and features,
            **traits._asdict(),
            "repetitions": chosen.repetitions or (features and is_body),
            "details": details(self.skeleton),
            "ends_alone": is_body and not self.offline,
            "adopts": features and not is_body,
            "labels_late": self._labels_late,
            "offline": self.offline,
        }

    def new_row(self) -> NDArray[np.uint8]:
        """Return the bytes of a row that has seen no frame."""
        row = new_row(self.record)
        self._prepare_counting(row)
        return row

    def prepare(self, row: NDArray[np.uint8]) -> None:
        """Set the constants of a row from outside."""
        lay_out(row, self.record)
        self._prepare_counting(row)

    def _prepare_counting(self, row: NDArray[np.uint8]) -> None:
        for header in region(row, "counted"):
            prepare_counting(header, self.skeleton, self.channel)

    def with_settings(self, settings: Settings) -> "Plan":
        """Return the plan for other settings of a stream, with the room that its row has."""
        ring, room, _ = self.sizes
        return Plan(self.skeleton, settings, self.fps, ring, channel=self.channel, room=room)

    def with_sizes(self, ring: int, room: int, window: int) -> "Plan":
        """Return the same plan with more room; see `sizes`."""
        history, bouts = self._kept
        return Plan(
            self.skeleton,
            self.user_settings,
            self.fps,
            ring,
            channel=self.channel,
            window=window,
            room=room,
            history=history,
            bouts=bouts,
            offline=self.offline,
        )


@lru_cache(KNOWN)
def shared_plan(skeleton: Skeleton, settings: Settings, fps: float | None, channel: str = BODY) -> Plan:
    """Return a plan, the same one for the same skeleton, settings, rate and channel; see `Plan`."""
    return Plan(skeleton, settings, fps, channel=channel)


def history_size(seconds: float) -> int:
    """Return the number of poses that cover `seconds` and the speed window before them."""
    return int((seconds + SPEED_WINDOW + 2 * SPACING) / SPACING) + 4
