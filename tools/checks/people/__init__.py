"""Scenes of several people whose tracker loses, exchanges and reuses ids, and what slots make of them."""
