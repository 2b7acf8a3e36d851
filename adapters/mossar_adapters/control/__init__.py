"""Requests to a running pipeline, over ZeroMQ and OSC."""
