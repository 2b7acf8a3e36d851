"""Archives of recordings on Ray Data: folder or bucket in, Parquet tables out.

    listing ──▶ parts of some recordings each ──▶ segmented, anywhere ──▶ one file per part and table

`segmenting` knows nothing of the engine; `places`, `tables` and `job` are the shell around it.
"""
