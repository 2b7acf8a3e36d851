"""ZeroMQ: frames in by SUB, events and frames out by PUB."""
