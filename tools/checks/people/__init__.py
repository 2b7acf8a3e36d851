"""Scenes of several people whose tracker loses, exchanges and reuses ids, and the results of slots."""
