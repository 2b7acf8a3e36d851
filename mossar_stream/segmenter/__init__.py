"""Segmenter: frames of one performer in, events out; with limbs and all that reads the frames."""

from mossar_stream.segmenter.segmenter import Segmenter as Segmenter
