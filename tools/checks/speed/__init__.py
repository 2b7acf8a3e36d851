"""Speed: what developers measure beside `mossar bench`; `python -m checks.speed`.

Each module measures one thing with the parts of `mossar_tools.bench`. Some look below the public face, since they time
single kernels.
"""
