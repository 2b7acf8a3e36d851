"""Whole recordings: the offline segmentation, and its results as people look at them."""

from mossar_stream.recording.offline import KeyFrame, Result, Segment, Segmentation, segment_recording

__all__ = ["KeyFrame", "Result", "Segment", "Segmentation", "segment_recording"]
