"""Mossar, step by step in the order of the data's way, and the same on whole arrays."""
