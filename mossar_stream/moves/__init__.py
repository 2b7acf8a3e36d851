"""Moves: recognition of movements that a user showed once or twice.

Written from Taranta, Samiei, Maghoumi, Khaloo, Pittman, LaViola: "Jackknife: a reliable recognizer with few samples
and many modalities" (2017): an example is cut into pieces of equal path, and the directions of the pieces are compared
by dynamic time warping, corrected by how alike the shares of path and the boxes are. Three things differ: joints are
relative to the body's centre, the corrections weigh more, and a clear lead over the other moves counts as evidence.
"""
