"""Following: progress of a performer in a movement that was shown, tempo, and deviation of the body.

bones        which bones an example and a stream share, and to which limbs they belong
bank         examples described for a stream: directions of bones, phase by phase
layout       how the bytes of a bank, and of a performer, are laid out
sampling     frames in, directions of bones out, 15 times a second
warping      a stream's samples aligned with an example: causal, open at both ends
tracking     states of a performance: begun, progress, done, left
repeated     counted repetitions, aligned with both ends known
alignment    the reader that follows one performer's frames and makes events
"""
