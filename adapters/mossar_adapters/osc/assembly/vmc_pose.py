"""From VMC's local bone transforms to joint positions.

Unity is left-handed. Mirroring x makes it right-handed: positions (-x, y, z), rotations (x, -y, -z, w).
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.kinematics import MotionChunk, joint_positions
from mossar_adapters.osc.assembly.humanoid import present_parents, rest_skeleton
from mossar_adapters.osc.assembly.known_joints import Row
from mossar_stream import Skeleton

MIRROR = np.array([-1.0, 1.0, 1.0, 1.0, -1.0, -1.0, 1.0])  # x y z, quaternion x y z w
BUILT_IN = rest_skeleton()
_ZERO = 1e-6  # m; bones nearer than this to their parents have no position of their own
# Bones that cannot lie in their parents, as Spine, Neck and shoulders may: if one does, its position was not sent.
_FAR = {f"{side}{part}" for side in ("Left", "Right") for part in ("LowerArm", "Hand", "LowerLeg", "Foot")}


class VmcPose:
    """The bones of one performer.

    Args:
        bones: Humanoid bones in the order of the rows.
        rest: Where bones are at rest, (3,) metres, for senders of rotations only.
        forced: Whether `rest` replaces positions even if they are sent.
    """

    def __init__(
        self, bones: Sequence[str], rest: Mapping[str, NDArray[np.float64]], *, forced: bool = False
    ) -> None:
        self._parents = present_parents(bones)
        self._hanging = np.array([parent >= 0 for parent in self._parents])
        self._forced = forced
        self._far = np.array([bone in _FAR for bone in bones])
        self._seen = np.zeros(len(bones), dtype=bool)  # bones that came,
        self._placed = np.zeros(len(bones), dtype=bool)  # and those that came with a position
        # (J, 3) metres.
        self._offsets = np.array(
            [
                _offset(bone, bones[parent] if parent >= 0 else None, rest)
                for bone, parent in zip(bones, self._parents, strict=True)
            ]
        )
        root = bones.index("Hips") if "Hips" in bones else -1
        self.skeleton = Skeleton(tuple(bones), self._parents, root)

    def positions(self, table: NDArray[np.float64], root: Row | None) -> NDArray[np.float64]:
        """Return the positions of the joints.

        Args:
            table: (J, 7) local position and quaternion as sent, NaN where a bone did not come.
            root: The same 7 numbers for the whole, or None.

        Returns:
            (J, 3) metres, right-handed; NaN for bones that did not come and all that hangs on them.
        """
        own = table * MIRROR
        translations = self._translations(own[:, :3])
        rotations = rotations_of(own[:, 3:])
        if root is not None:
            whole = np.array(root) * MIRROR
            turn = rotations_of(whole[3:])
            top = ~self._hanging
            translations[top] = translations[top] @ turn.T + whole[:3]
            rotations[top] = turn @ rotations[top]
        chunk = MotionChunk(rotations[None], translations[None], np.zeros(1))
        placed: NDArray[np.float64] = joint_positions(chunk, self._parents)[0]
        return placed

    def _translations(self, sent: NDArray[np.float64]) -> NDArray[np.float64]:
        with np.errstate(invalid="ignore"):
            moved = (np.abs(sent) > _ZERO).any(axis=1)
        self._seen |= ~np.isnan(sent).any(axis=1)
        self._placed |= moved
        resting = self._seen & ~self._placed & self._hanging  # bones that came with rotations only
        if self._forced:
            resting = self._hanging
        elif not (resting & self._far).any() and (self._placed & self._hanging).any():
            return sent.copy()
        resting = resting | (~self._hanging & ~moved)
        return np.where(np.isnan(sent) | ~resting[:, None], sent, self._offsets)


def _offset(bone: str, parent: str | None, rest: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return a bone's rest place relative to its parent's; of the built-in skeleton if `rest` lacks one."""
    known = rest if bone in rest and (parent is None or parent in rest) else BUILT_IN
    return known[bone] if parent is None else known[bone] - known[parent]


def rotations_of(quaternions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return rotation matrices of quaternions of any length above zero.

    Args:
        quaternions: (..., 4) x y z w.

    Returns:
        (..., 3, 3) float64.
    """
    x, y, z, w = np.moveaxis(quaternions, -1, 0)
    scale = 2.0 / (x * x + y * y + z * z + w * w)
    xs, ys, zs = x * scale, y * scale, z * scale
    matrix = np.empty((*quaternions.shape[:-1], 3, 3))
    matrix[..., 0, 0] = 1.0 - (y * ys + z * zs)
    matrix[..., 0, 1] = x * ys - w * zs
    matrix[..., 0, 2] = x * zs + w * ys
    matrix[..., 1, 0] = x * ys + w * zs
    matrix[..., 1, 1] = 1.0 - (x * xs + z * zs)
    matrix[..., 1, 2] = y * zs - w * xs
    matrix[..., 2, 0] = x * zs - w * ys
    matrix[..., 2, 1] = y * zs + w * xs
    matrix[..., 2, 2] = 1.0 - (x * xs + y * ys)
    return matrix
