"""What compiled code computes, in plain Python: the oracles that tests compare it with."""
