"""The dashboard: a page in the browser that shows what the segmenter thinks, and lets people move the level.

    frames, events ──▶ show (live or recorded) ──▶ glimpses ──▶ page: scene, chart, tables
                           ▲                                       │
                           └────────── controls ◀──────────────────┘

A show keeps what is needed of the recent past, bounded. The page looks at it from a thread of its own, 30 times a
second at most, so that drawing never holds up the stream.
"""
