"""The dashboard: a page in the browser that shows the segmentation, and has controls for the level.

    frames, events ──▶ show (live or recorded) ──▶ glimpses ──▶ page: scene, chart, tables
                           ▲                                       │
                           └────────── controls ◀──────────────────┘

A show keeps the needed part of the recent past, bounded. The page looks at it from a thread of its own, 30 times a
second at most, so that drawing never holds up the stream.
"""
