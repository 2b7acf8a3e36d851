"""Bench: speed, delay and memory, measured by one command on the machine at hand; `mossar bench`.

Each module measures one thing and yields `Measurement`s; `measures.py` lists them. Times are taken by the wall and by
the processor: where neighbours take the processor away, the table shows processor time, with a note.
"""
