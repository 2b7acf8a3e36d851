"""Fuzz: damaged input for every reader of foreign data.

`python -m checks.fuzz --inputs N --seed S` prints for each target how many inputs it was given, which of them it
failed on, and the slowest. `python -m checks.fuzz.guided TARGET` looks for new code with atheris instead of by chance.
"""
