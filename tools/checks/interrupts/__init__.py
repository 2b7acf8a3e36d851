"""Ctrl-C at random moments: the events are those of a run with the interrupted call, without it, or with a part of its frames.

Segmenters, and pools of performers, with limbs, moves, followed moves, held poses, steps and repetitions get frames, changes and ends of takes.
An exception comes in the midst of each. Ids, revisions and takes are as documented all the time, and for a share of the
exceptions the later reports are compared with runs from an earlier snapshot.
"""
