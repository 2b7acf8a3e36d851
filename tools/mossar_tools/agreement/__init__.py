"""Agreement: how well people, or a person and the program, agree on the labels of the same recordings."""
