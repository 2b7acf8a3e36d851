"""Checks: programs that developers run against the project; they are no part of what is installed.

`pip install -e .` makes them importable; each is run as `python -m checks.NAME`, and CONTRIBUTING.md lists them.
"""
