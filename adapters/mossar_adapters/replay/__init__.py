"""Recordings and live streams on their way out again as frames, at their own pace."""
