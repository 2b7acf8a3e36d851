"""Soak: a day's worth of frames at high speed through the whole pipeline, while everything around it goes wrong.

`python -m checks.soak --minutes N` sends frames of several performers over ZeroMQ, damaged as networks, sensors
and clocks damage them, and compares every event with the expected one, which `truth` computes.
"""
