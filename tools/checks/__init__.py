"""Checks: programs that developers run against the project; they are not installed.

`pip install -e .` makes them importable; each is run as `python -m checks.NAME`, and CONTRIBUTING.md lists them.
"""
