"""Held poses: postures that a user showed, recognised while a performer holds them.

layout     layout of the bytes of shown poses, and of a performer
bank       poses described for a stream: directions of bones, relative to the facing of hips and shoulders
matching   frames in; the held pose, and the body's deviation from it, out
holding    the reader that follows one performer's frames and makes events
"""
