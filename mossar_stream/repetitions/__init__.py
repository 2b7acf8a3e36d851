"""Repetitions: their number and period, and the phase of the performer in the cycle.

The count is causal and needs no trained classes. A pose becomes a sample when it has moved far enough from the last one.
The leading components of the posture over the latest samples show cycles. Neighbouring cycles that are alike are counted,
and later evidence may revise the count.
"""
