"""The paper's experiments on labelled recordings: `python -m checks.paper DIR`."""
