"""Repetitions of a movement: how many, how often, and where in the cycle."""
