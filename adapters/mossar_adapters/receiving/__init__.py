"""From what a wire carries to frames: who may send, who is who, when, and what goes on together."""
