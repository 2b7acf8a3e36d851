"""Segment a recording and look at its hierarchy: `python examples/segment_recording.py walk.bvh`."""

import sys

from mossar_adapters.files import read

take = read(sys.argv[1])
result = take.segment(level="motion")  # take.positions (n, J, 3) in metres, take.times (n,) in seconds
print(f"{len(result.key_frames)} key frames of Algorithm 2; the strongest of them:")
for key in sorted(result.key_frames, key=lambda key: -key.strength)[:5]:
    print(f"  {key.time:7.2f} s  {key.kind:<8} strength {key.strength:.2f}")
print("segments at level motion:")
for segment in result.at("motion").segments:
    joints = ", ".join(segment.active_joints[:3])
    print(f"  {segment.start_time:7.2f} to {segment.end_time:7.2f} s  {segment.state:<8} {joints}")
