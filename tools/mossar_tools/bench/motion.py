"""Motion: endless frames to push, real or of the built-in performer.

A recording is played to and fro, so that it goes on for any number of frames without a jump.
"""

from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.demo import performance
from mossar_stream import Skeleton

JOINTS = 31  # of the usual skeleton of motion capture, for which the targets are stated
FPS = 120.0  # Hz, of the built-in performer here
BREAK = 10.0  # s between recordings: another take begins
GOLDEN = 0.618034  # multiples of it, less whole numbers, never come together
CROWD_FPS = 30.0  # Hz, of performers in a crowd

Chunk = tuple[NDArray[np.float32], NDArray[np.float64]]


class Motion(msgspec.Struct, frozen=True):
    """Frames that can be gone through again and again.

    Args:
        name: For the table.
        skeleton: J joints.
        fps: Rate, Hz.
        positions: (n, J, 3) m; the last frame is followed by the first.
        times: (n,) s, from 0.
    """

    name: str
    skeleton: Skeleton
    fps: float
    positions: NDArray[np.float32]
    times: NDArray[np.float64]

    def chunks(self, count: int, size: int) -> list[Chunk]:
        """Return `count` frames in chunks of at most `size`: views of the positions, and times that go on."""
        period = float(self.times[-1]) + 1.0 / self.fps
        found: list[Chunk] = []
        left, turn = count, 0
        while left > 0:
            for start in range(0, min(len(self.times), left), size):
                part = slice(start, min(start + size, len(self.times), left))
                found.append((self.positions[part], self.times[part] + turn * period))
            left -= len(self.times)
            turn += 1
        return found

    def slowed(self, fps: float) -> "Motion":
        """Return about this rate by leaving frames out."""
        step = max(1, round(self.fps / fps))
        positions = np.ascontiguousarray(self.positions[::step])
        times = np.arange(len(positions)) * (step / self.fps)
        return msgspec.structs.replace(self, fps=self.fps / step, positions=positions, times=times)


def to_and_fro(name: str, skeleton: Skeleton, fps: float, positions: NDArray[np.float32]) -> Motion:
    """Return the motion of a recording.

    Args:
        name: For the table.
        skeleton: J joints.
        fps: Rate, Hz.
        positions: (n, J, 3) m.
    """
    there_and_back = np.ascontiguousarray(np.concatenate([positions, positions[-2:0:-1]]))
    return Motion(name, skeleton, fps, there_and_back, np.arange(len(there_and_back)) / fps)


def joined(name: str, motions: Sequence[Motion]) -> Motion:
    """Return motions of one skeleton in sequence, each a take of its own."""
    times, start = [], 0.0
    for motion in motions:
        times.append(start + motion.times)
        start = float(times[-1][-1]) + BREAK
    positions = np.concatenate([motion.positions for motion in motions])
    return Motion(name, motions[0].skeleton, motions[0].fps, positions, np.concatenate(times))


def performer(seconds: float, joints: int = JOINTS, seed: int = 1) -> Motion:
    """Return the motion of the built-in performer, brought to a number of joints."""
    take = performance(seed, fps=FPS, seconds=seconds)
    skeleton, positions = with_joints(take.skeleton, take.frames.positions, joints)
    return to_and_fro("built-in performer", skeleton, FPS, positions)


def with_joints(
    skeleton: Skeleton, positions: NDArray[np.float32], count: int
) -> tuple[Skeleton, NDArray[np.float32]]:
    """Return a body with another number of joints: some left out, or more of them along the bones.

    Args:
        skeleton: J joints.
        positions: (n, J, 3) m.
        count: How many there shall be, at least 2.
    """
    have, bones = len(skeleton), [(j, parent) for j, parent in enumerate(skeleton.parents) if parent >= 0]
    if count < have:
        root = max(skeleton.root, 0)
        others = [j for j in range(have) if j != root]
        kept = [root, *(others[i * len(others) // (count - 1)] for i in range(count - 1))]
        fewer = tuple(skeleton.names[j] for j in kept)
        return Skeleton(fewer, (-1, *(0 for _ in fewer[1:]))), np.ascontiguousarray(positions[:, kept])
    lines, names, parents = [positions], list(skeleton.names), list(skeleton.parents)
    for extra in range(count - have):
        j, parent = bones[extra % len(bones)]
        share = np.float32(0.1 + 0.8 * (GOLDEN * (have + extra) % 1.0))
        lines.append(
            positions[:, parent, None] + share * (positions[:, j, None] - positions[:, parent, None])
        )
        names.append(f"{skeleton.names[j]}+{have + extra}")
        parents.append(parent)
    return Skeleton(tuple(names), tuple(parents), skeleton.root), np.concatenate(lines, axis=1)
