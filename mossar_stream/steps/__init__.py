"""Steps: the times at which a foot leaves the ground and comes down again."""
