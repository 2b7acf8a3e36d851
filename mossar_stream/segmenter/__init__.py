"""Segmenter: frames of one performer in, events out; with limbs and readers."""

from mossar_stream.segmenter.segmenter import Segmenter as Segmenter
