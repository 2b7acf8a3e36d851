"""Recording: Mossar offline, and its results for notebooks."""

from mossar_stream.recording.recording import KeyFrame as KeyFrame
from mossar_stream.recording.recording import Result as Result
from mossar_stream.recording.recording import Segment as Segment
from mossar_stream.recording.recording import Segmentation as Segmentation
from mossar_stream.recording.recording import segment_recording as segment_recording
