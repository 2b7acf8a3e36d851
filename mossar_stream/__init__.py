"""Streaming Mossar: tells, live, where one human motion ends and the next begins."""
