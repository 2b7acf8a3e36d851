"""How alike two neighbouring segments are: the protocol and the measures behind it."""
