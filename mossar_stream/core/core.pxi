"""The compiled core: frames in, records of events out. The files follow each other in the order of the data."""

cimport numpy as cnp
from libc.math cimport (
    INFINITY, M_PI, NAN, acos, asin, atan2, ceil, cos, exp, exp2, expf, fabsf, floor, fmod, hypot, isfinite, isnan, log, log1p,
    logf, pow, rint, rintf, sin, sqrt, sqrtf, tanh,
)
from libc.stdint cimport int8_t, int16_t, int32_t, int64_t, uint8_t, uint64_t
from libc.stdlib cimport calloc, free, malloc
from libc.string cimport memcpy, memset

cnp.import_array()

include "build.pxi"
# Basic types and functions.
include "numbers.pxi"
include "spans.pxi"
include "simd.pxi"
include "plan.pxi"
include "clock.pxi"
include "event_buffer.pxi"
include "joint_pages.pxi"
include "slots.pxi"
# The frame step: time, joints, velocity, splitter.
include "joints.pxi"
include "velocity.pxi"
include "normalisation.pxi"
include "noise.pxi"
include "one_euro.pxi"
include "mean_pose.pxi"
include "tempo.pxi"
include "scales.pxi"
include "splitter.pxi"
include "pose_history.pxi"
include "localising.pxi"
include "candidate_features.pxi"
include "dwells.pxi"
include "activity.pxi"
# Summaries of segments, and their similarity.
include "../similarity/summary.pxi"
include "../similarity/sums.pxi"
include "../similarity/evidence.pxi"
include "../similarity/likelihood.pxi"
include "../similarity/path_kernel/pyramid.pxi"
include "../similarity/path_kernel/graph.pxi"
include "../similarity/path_kernel/blocks.pxi"
include "../similarity/path_kernel/frontier.pxi"
include "../similarity/path_kernel/path_sum.pxi"
include "../similarity/path_kernel/kernel.pxi"
include "../similarity/protocol.pxi"
# Repetitions.
include "../repetitions/state.pxi"
include "../repetitions/sampling.pxi"
include "../repetitions/components.pxi"
include "../repetitions/turning.pxi"
include "../repetitions/alike.pxi"
include "../repetitions/anchoring.pxi"
include "../repetitions/timing.pxi"
include "../repetitions/counting.pxi"
include "ways.pxi"
include "repetition_labels.pxi"
# Segments and key frames: Algorithm 3 over a window.
include "open_segment.pxi"
include "arrival.pxi"
include "remerging.pxi"
include "window.pxi"
include "rests.pxi"
include "location.pxi"
include "decision.pxi"
include "row.pxi"
include "window_step.pxi"
include "frame_step.pxi"
# Readers of the frames.
include "../steps/tracking.pxi"
include "../moves/points.pxi"
include "../moves/facing.pxi"
include "../moves/measure.pxi"
include "../moves/store.pxi"
include "../moves/track.pxi"
include "../moves/activity.pxi"
include "../moves/recogniser.pxi"
include "../moves/bank.pxi"
include "../following/layout.pxi"
include "../following/sampling.pxi"
include "../following/warping.pxi"
include "../following/repeated.pxi"
include "../following/tracking.pxi"
include "../poses/layout.pxi"
include "../poses/matching.pxi"
# The one loop.
include "middle.pxi"
include "run.pxi"
# Owners of memory; events from records.
from mossar_stream.core.records import record_types

include "channel.pxi"
include "out.pxi"
include "../repetitions/out.pxi"
include "reader.pxi"
include "../moves/out.pxi"
include "../following/out.pxi"
include "../poses/out.pxi"
include "../steps/out.pxi"
include "placing.pxi"
include "performer.pxi"
# Functions for Python.
include "../similarity/comparison.pxi"
include "face.pxi"
include "../similarity/face.pxi"
include "../moves/face.pxi"
include "../following/face.pxi"
include "../poses/face.pxi"
# Functions for tests.
include "testing.pxi"
include "../similarity/testing.pxi"
include "../moves/testing.pxi"
