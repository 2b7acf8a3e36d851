"""Limbs: key frames and segments of each arm, each leg and the trunk, beside those of the body.

A limb is segmented like a body of its own: equation 1 over its joints, relative to where it hangs (shoulder, hip), so
that steps do not leak into arms; a splitter, a range and a window of its own; strengths by the same measure,
restricted to its joints.
"""
