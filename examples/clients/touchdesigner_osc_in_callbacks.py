"""TouchDesigner: the callbacks of an OSC In DAT on port 9000. Not run in TouchDesigner, which was not at hand.

Start: mossar run SOURCE --to osc://127.0.0.1:9000. Make an OSC In DAT, paste this into its callbacks DAT, and a Table DAT
called `key_frames`, a Constant CHOP called `moving`: rows are appended to the one, the other is 1 from onset to offset.
"""

# Of the arguments performer, status, kind, take, frame, time, decided_time, velocity, strength, rev:
STATUS, KIND, TIME = 1, 2, 5


def onReceiveOSC(dat, rowIndex, message, bytes, timeStamp, address, args, peer):  # noqa: N802, A002, ANN001, ANN201, ARG001
    """React to one message; the name and the arguments are TouchDesigner's."""
    if address != "/mossar/key_frame" or args[STATUS] != "confirmed":
        return
    op("key_frames").appendRow([args[0], args[KIND], args[TIME]])  # noqa: F821 - TouchDesigner's
    if args[KIND] != "minimum":
        op("moving").par.value0 = int(args[KIND] == "onset")  # noqa: F821
