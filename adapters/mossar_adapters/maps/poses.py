"""Poses in JSON lines that are no maps of ours: the shapes of pose estimators, as files of them have (`files.pose_frames`)."""

import msgspec
import numpy as np

from mossar_adapters.files import pose_frames
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.units import Scale, fitted_scale, height, stated_scale
from mossar_adapters.joint_sets import printable_names, with_known_parents
from mossar_adapters.maps.json_nan import without_nan
from mossar_adapters.receiving.pose import Pose
from mossar_stream import FrameError, Skeleton

_KEPT = 64  # skeletons


class PoseDecoder:
    """Turns objects without a `type` into poses.

    Args:
        options: The user's unit, and whether flat poses are wanted.

    Example:
        >>> decoder = PoseDecoder(ReadOptions(unit="m"))
        >>> line = b'{"t": 0.5, "joints": {"hips": [0, 1, 0], "neck": [0, 1.5, 0], "head": [0, 1.7, 0]}}'
        >>> [pose] = decoder.receive(line, 0.0)
        >>> pose.performer, pose.time, pose.skeleton.names
        ('p1', 0.5, ('hips', 'neck', 'head'))
    """

    def __init__(self, options: ReadOptions) -> None:
        self._options = options
        self._scale: Scale | None = None  # that of the first pose whose height can be measured
        self._skeletons: dict[tuple[str, ...], Skeleton] = {}

    def receive(self, line: bytes, arrival: float) -> list[Pose]:
        """Return the poses in a line, none if it is another object.

        Args:
            line: JSON.
            arrival: Time of arrival, s.

        Raises:
            FrameError: If it is no JSON, or holds poses that cannot be used.
        """
        try:
            content = msgspec.json.decode(without_nan(line) or line)
        except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
            raise FrameError(str(error)) from None
        if not isinstance(content, dict) or "type" in content or not pose_frames.may_hold_poses(content):
            return []
        try:
            time, poses = pose_frames.poses_of(content, allow_2d=self._options.allow_2d)
        except pose_frames.PoseError as error:
            raise FrameError(str(error)) from None
        return [self._pose(pose, f"p{i + 1}", time, arrival) for i, pose in enumerate(poses)]

    def _pose(self, found: pose_frames.Pose, performer: str, time: float | None, arrival: float) -> Pose:
        scale = self._scale or self._measured(found)
        return Pose(
            performer,
            found.positions * scale.metres,
            arrival,
            time,
            None if found.confidence is None else np.nan_to_num(found.confidence),
            self._skeleton(found.names),
            scale.note or "m",
        )

    def _measured(self, found: pose_frames.Pose) -> Scale:
        tall = height(found.positions[None])
        scale = stated_scale(self._options, 1.0) if found.metric else fitted_scale(self._options, tall)
        if tall > 0:
            self._scale = scale
        return scale

    def _skeleton(self, names: tuple[str, ...]) -> Skeleton:
        known = self._skeletons.get(names)
        if known is None:
            if len(self._skeletons) == _KEPT:
                self._skeletons.clear()
            parents, root = with_known_parents(names)
            known = self._skeletons[names] = printable_names(Skeleton(names, parents, root))
        return known
