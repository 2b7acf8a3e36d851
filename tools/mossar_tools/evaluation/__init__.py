"""Evaluation: the accuracy of key frames against the true cuts of labelled recordings.

In the order of the data: `labels` and `takes` read recordings with their true cuts, `judges` makes one truth of several
people's cuts, `mossar` and `chance` are the methods, `trial` runs them, `matching` and `metrics` score them, `report` and
`strips` show the result.
"""
