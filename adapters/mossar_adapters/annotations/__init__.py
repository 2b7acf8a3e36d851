"""Annotations: tiers of labelled times, in the files of the programs that people annotate with."""
