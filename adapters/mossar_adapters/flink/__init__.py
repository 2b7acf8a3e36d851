"""Live streams of many performers on Apache Flink.

    topic or files of records ──▶ keyed by performer ──▶ a segmenter each, its snapshot as state ──▶ events

`records`, `following` and `job` know nothing of the engine; `function`, `ends` and `engine` are the shell around them.
"""
