"""OSC over UDP: skeletons in through several profiles, events and frames out."""
