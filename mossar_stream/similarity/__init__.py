"""Similarity of two neighbouring segments: the protocol and the measures behind it."""
