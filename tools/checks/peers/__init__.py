"""Peers: other libraries that find changes in streams, beside ours on the same recordings; `python -m checks.peers`.

Each peer gets its input frame by frame: the velocity curve of equation 1, computed beforehand and free of
charge, or the poses. Its settings are the best of a coarse grid for each level (`python -m checks.peer_settings
DIR` searches again).
"""
