"""Following: how far a performer is in a movement that was shown, how fast, and where the body strays.

bones        which bones an example and a stream share, and to which limbs they belong
bank         examples described for a stream: directions of bones, phase by phase
layout       how the bytes of a bank, and of a performer, are laid out
sampling     frames in, directions of bones out, 15 times a second
warping      a stream's samples aligned with an example: causal, open at both ends
tracking     what becomes of it: begun, progress, done, left
repeated     repetitions that the counter knows, aligned with both ends known
alignment    the reader that follows one performer's frames and makes events
"""
