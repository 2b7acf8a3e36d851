"""Steps: when a foot leaves the ground, and when it comes down again."""
