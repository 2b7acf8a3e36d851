"""Speed: measures for developers, beside `mossar bench`; `python -m checks.speed`.

Each module measures one thing with the parts of `mossar_tools.bench`. Some use private parts of the core, since they time
single kernels.
"""
