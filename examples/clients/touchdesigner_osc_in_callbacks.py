"""TouchDesigner: the callbacks of an OSC In DAT on port 9000. Not run in TouchDesigner, which was not at hand.

Start: mossar run SOURCE --to osc://127.0.0.1:9000. Make an OSC In DAT, paste this into its callbacks DAT, and a Table DAT
called `key_frames`, Table DATs called `moves`, `steps`, `followed` and `poses`, and Constant CHOPs called `moving` and `progress`: rows are appended
to the tables, `moving` is 1 while the body moves, `progress` is 0 to 1 along a followed move.
"""

# Of the arguments performer, status, kind, take, frame, time, decided_time, velocity, strength, rev; of a move performer, status,
# name, limb, take, start, end, decided_time, score, rev; of activity performer, channel, state, take, start, decided_time, previous;
# of a step performer, status, side, take, time; of a followed move performer, status, name, limb, joint, take, count, progress, tempo,
# certainty, deviation, score, then times, id, rev and limbs; of a pose performer, status, name, limb, joint, take, start, seconds, deviation:
STATUS, KIND, TIME = 1, 2, 5
NAME, LIMB = 2, 3
CHANNEL, STATE = 1, 2
SIDE, STEP_TIME = 2, 4
COUNT, PROGRESS, DEVIATION, SCORE = 6, 7, 10, 11
SECONDS = 7


def onReceiveOSC(dat, rowIndex, message, bytes, timeStamp, address, args, peer):  # noqa: N802, A002, ANN001, ANN201, ARG001
    """React to one message; the name and the arguments are TouchDesigner's."""
    if address == "/mossar/key_frame" and args[STATUS] == "confirmed":
        op("key_frames").appendRow([args[0], args[KIND], args[TIME]])  # noqa: F821 - TouchDesigner's
    elif address == "/mossar/move" and args[STATUS] == "confirmed":
        op("moves").appendRow([args[0], args[NAME], args[LIMB]])  # noqa: F821
    elif address == "/mossar/step" and args[STATUS] == "strike":
        op("steps").appendRow([args[0], args[SIDE], args[STEP_TIME]])  # noqa: F821
    elif address == "/mossar/follow":
        over = args[STATUS] in {"done", "left"}
        op("progress").par.value0 = 0.0 if over else args[PROGRESS]  # noqa: F821
        if args[STATUS] == "done":
            op("followed").appendRow([args[0], args[NAME], args[COUNT], args[DEVIATION], args[SCORE]])  # noqa: F821
    elif address == "/mossar/pose" and args[STATUS] == "left":
        op("poses").appendRow([args[0], args[NAME], args[SECONDS]])  # noqa: F821
    elif address == "/mossar/activity" and args[CHANNEL] == "body":
        op("moving").par.value0 = int(args[STATE] == "moving")  # noqa: F821
