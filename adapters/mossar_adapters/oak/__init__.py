"""OAK cameras as a source of frames, `oak:`."""
