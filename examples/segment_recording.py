"""Segment a recording and look at its hierarchy: `python examples/segment_recording.py walk.bvh`."""

import sys

import numpy as np

from mossar_adapters.files import open_recording
from mossar_stream import Settings, segment_recording

recording = open_recording(sys.argv[1])
chunks = [frames for frames in recording.chunks() if frames.performer == recording.performers[0]]
positions = np.concatenate([frames.positions for frames in chunks])  # (n, J, 3) metres, NaN where missing
times = np.concatenate([frames.times for frames in chunks])  # (n,) seconds

result = segment_recording(
    positions, recording.fps, recording.skeleton, Settings(level="motion", range="file"), times=times
)
print(f"{len(result.key_frames)} key frames of Algorithm 2; the strongest of them:")
for key in sorted(result.key_frames, key=lambda key: -key.strength)[:5]:
    print(f"  {key.time:7.2f} s  {key.kind:<8} strength {key.strength:.2f}")
print("segments at level motion:")
for segment in result.at("motion").segments:
    joints = ", ".join(segment.active_joints[:3])
    print(f"  {segment.start_time:7.2f} to {segment.end_time:7.2f} s  {segment.state:<8} {joints}")
