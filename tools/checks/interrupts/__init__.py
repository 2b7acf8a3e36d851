"""Ctrl-C at random moments: the events are those of a run with what it cut short, without it, or with a part of its frames.

Segmenters, and pools of performers, with limbs, moves, followed moves, held poses, steps and repetitions get frames, changes and ends of takes.
An exception comes in the midst of each. Ids, revisions and takes are as documented all the time, and for a share of the
exceptions what is reported from then on is compared with runs from a snapshot made before.
"""
