"""The selection from a recording: some joints, another root, one performer."""

from collections.abc import Iterator

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.files.errors import FileError
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.source import Recording
from mossar_stream import FrameError, Frames, Skeleton


def selected(recording: Recording, options: ReadOptions) -> Recording:
    """Return the recording with the root, joints and performer that the options name.

    Raises:
        FileError: If there is no such joint or performer.
    """
    try:
        skeleton, note = selected_skeleton(recording.skeleton, options)
    except FrameError as error:
        raise FileError(recording.path, str(error)) from None
    performers, count = recording.performers, recording.frame_count
    if options.performer is not None:
        if options.performer not in performers:
            raise FileError(
                recording.path,
                f"no performer called {options.performer!r}; there are {', '.join(performers[:40])}",
            )
        count = count if len(performers) == 1 else None
        performers = (options.performer,)
    joints = np.array([recording.skeleton.index(name) for name in options.joints], dtype=np.intp)

    def chunks() -> Iterator[Frames]:
        for frames in recording.chunks():
            if frames.performer in performers:
                yield of_joints(frames, joints)

    return msgspec.structs.replace(
        recording,
        skeleton=skeleton,
        performers=performers,
        frame_count=count,
        chunks=chunks,
        notes=(*recording.notes, note) if note else recording.notes,
        reference=() if options.joints else recording.reference,
    )


def selected_skeleton(skeleton: Skeleton, options: ReadOptions) -> tuple[Skeleton, str]:
    """Return the skeleton with the root and joints that the options name, and notes for the user.

    Raises:
        FrameError: If there is no such joint, or the wanted root is not among the joints.
    """
    if options.root is not None:
        skeleton = skeleton.with_root(options.root)
    if not options.joints:
        return skeleton, ""
    chosen = skeleton.select(options.joints)
    if skeleton.root < 0 or skeleton.names[skeleton.root] in chosen.names:
        return chosen, ""
    lost, found = skeleton.names[skeleton.root], chosen.names[chosen.root]
    if options.root is not None:
        raise FrameError(
            f"the root {lost} is not among the joints {', '.join(chosen.names[:40])}; add it to them"
        )
    return chosen, f"the centre of the body, {lost}, is not among the joints; {found} is taken for it"


def of_joints(frames: Frames, joints: NDArray[np.intp]) -> Frames:
    """Return frames with these joints only; with all of them if there is none."""
    if not len(joints):
        return frames
    confidence = None if frames.confidence is None else np.ascontiguousarray(frames.confidence[:, joints])
    return msgspec.structs.replace(
        frames, positions=np.ascontiguousarray(frames.positions[:, joints]), confidence=confidence
    )
