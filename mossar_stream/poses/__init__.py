"""Held poses: postures that a user showed, recognised while a performer holds them.

layout     how the bytes of shown poses, and of a performer, are laid out
bank       poses described for a stream: directions of bones, relative to the facing of hips and shoulders
matching   frames in; which pose is held, and how far the body strays from it
holding    the reader that follows one performer's frames and makes events
"""
