"""Agreement of people, or of a person and the program, on the labels of the same recordings."""
