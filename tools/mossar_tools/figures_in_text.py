"""Figures in text: poses of an example drawn with characters, for terminals."""

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Example, Skeleton
from mossar_tools.stick_figures import Floats, head_of, project, view_of

POSES = 5  # of an example, equally far apart along its path
_COLUMNS, _LINES = 10, 6  # characters of a figure
_WIDE, _HIGH = 2, 4  # dots of a character of the Braille block
_BRAILLE = 0x2800
_BITS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])  # of the dots of a character
_PLAIN = "*"


def example_lines(example: Example, skeleton: Skeleton, *, fine: bool) -> list[str]:
    """Return an example as some poses side by side, from its begin to its end.

    Args:
        example: The example.
        skeleton: Of the example.
        fine: Whether Braille characters can be printed; else there is a star where a bone is.
    """
    shown, _ = example.followed(len(skeleton), skeleton.root)
    poses = shown.astype(np.float64)
    return figure_lines(poses[_spread(poses, skeleton.root)], poses, skeleton, fine=fine)


def figure_lines(chosen: Floats, poses: Floats, skeleton: Skeleton, *, fine: bool) -> list[str]:
    """Return poses side by side.

    Args:
        chosen: (k, J, 3) m, the drawn poses.
        poses: (n, J, 3) m, of the same recording, for the vertical and the size of the body.
        skeleton: J joints.
        fine: See `example_lines`.
    """
    view = view_of(skeleton, poses)
    flat = np.stack([project(pose, view) for pose in chosen])
    low, high = flat.min(axis=(0, 1)), flat.max(axis=(0, 1))
    wide, high_dots = (_WIDE, _HIGH) if fine else (1, 2)
    size = np.array([_COLUMNS * wide, _LINES * high_dots])
    scale = float(np.min((size - 1) / np.maximum(high - low, 1e-6)))
    placed = (flat - (low + high) / 2) * (scale, -scale) + (size - 1) / 2
    return [
        " ".join(row).rstrip()
        for row in zip(*(_characters(pose, skeleton, size, fine=fine) for pose in placed), strict=True)
    ]


def _spread(poses: Floats, root: int) -> NDArray[np.intp]:
    """Return frames that are equally far apart along the path of the joints, the first and the last included."""
    centre = poses[:, root] if root >= 0 else poses.mean(axis=1)
    steps = np.linalg.norm(np.diff(poses - centre[:, None], axis=0), axis=2).sum(axis=1)
    path = np.concatenate([[0.0], np.cumsum(steps)])
    return np.searchsorted(path, np.linspace(0.0, path[-1], POSES)).clip(0, len(poses) - 1)


def _characters(pose: Floats, skeleton: Skeleton, size: NDArray[np.intp], *, fine: bool) -> list[str]:
    dots = np.zeros((size[1], size[0]), np.bool_)
    for one, other in skeleton.bones():
        _draw_line(dots, pose[one], pose[other])
    head = head_of(skeleton)
    for joint in [head] if head >= 0 else [] if skeleton.bones() else range(len(skeleton)):
        for way in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)):
            _draw_line(dots, pose[joint] + way, pose[joint] + way)
    if not fine:
        stars = np.asarray(dots.reshape(_LINES, 2, _COLUMNS).any(axis=1))
        return ["".join(_PLAIN if star else " " for star in row) for row in stars]
    cells = dots.reshape(_LINES, _HIGH, _COLUMNS, _WIDE).transpose(0, 2, 1, 3)
    codes = _BRAILLE + (cells * _BITS).sum(axis=(2, 3))
    return ["".join(" " if code == _BRAILLE else chr(code) for code in row) for row in codes.tolist()]


def _draw_line(dots: NDArray[np.bool_], begin: Floats, end: Floats) -> None:
    count = int(np.ceil(np.abs(end - begin).max())) + 1
    places = np.rint(np.linspace(begin, end, count)).astype(int)
    inside = (places >= 0).all(axis=1) & (places < (dots.shape[1], dots.shape[0])).all(axis=1)
    dots[places[inside, 1], places[inside, 0]] = True
