"""Repetitions: how often a movement was repeated, how fast, and where in the cycle it is.

Causal and without classes. Poses become samples at a constant rate; the leading components of the posture over the
last seconds show cycles; neighbours that are alike are counted, and later evidence may revise what was counted.
"""
