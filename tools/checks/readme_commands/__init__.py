"""Every command of the documentation is run literally, as a reader would type it.

`commands` finds them, `files` makes the files that they name, `stage` runs and judges them.
"""
