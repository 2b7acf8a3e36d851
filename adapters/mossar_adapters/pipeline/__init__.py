"""The pipeline: sources, segmenters and sinks in one run."""

from mossar_adapters.pipeline.outcome import Outcome
from mossar_adapters.pipeline.pipeline import Pipeline
from mossar_adapters.pipeline.snapshot import Snapshot, read_snapshot
from mossar_adapters.pipeline.upkeep import Upkeep

__all__ = ["Outcome", "Pipeline", "Snapshot", "Upkeep", "read_snapshot"]
