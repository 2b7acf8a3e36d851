"""Soak: a day's worth of frames at high speed through the whole pipeline, while everything around it goes wrong.

`python -m checks.soak --minutes N` sends frames of several performers over ZeroMQ, damaged as networks, sensors
and clocks damage them, and compares every event that comes out with what must come out. `truth` says what that is.
"""
