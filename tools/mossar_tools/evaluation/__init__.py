"""Evaluation: how well key frames meet the true cuts of labelled recordings.

In the order of the data's way: `labels` and `takes` bring recordings with their true cuts, `judges` makes one
truth of several people's, `mossar`, `velocity_based`, `recursion` and `chance` are the methods, `trial` runs them,
`matching` and `metrics` score them, `report` and `strips` show the result. `grid` and what follows it repeat the
paper's Tables 2 to 7 and Figures 11 to 14.
"""
