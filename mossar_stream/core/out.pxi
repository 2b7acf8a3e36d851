"""Out: records of the event buffer (event_buffer.pxi) become events, the ones that users see."""

from mossar_stream.events import (
    KEY_FRAME_KINDS, KEY_FRAME_STATUSES, SCHEMA_VERSION, SEGMENT_STATES, SEGMENT_STATUSES,
    ActivityEvent, KeyFrameEvent, SegmentEvent, StreamEvent,
)


cdef object event_of(Channel channel, Event* event):
    """Return the event of a record."""
    if event.take != channel.prefix_take:
        channel.prefix = f"{channel.performer}/{_of_limb(channel)}{event.take}/"
        channel.prefix_take = event.take
    if event.code == KEY_FRAME:
        return _key_frame(channel, event)
    if event.code == SEGMENT:
        return _segment(channel, event)
    if event.code == TAKE_START:
        return StreamEvent(performer=channel.performer, event="started", take=event.take)
    return _activity(channel, event)


cdef str _of_limb(Channel channel):
    """Return the part of an id that names the limb; empty for the body."""
    return "" if channel.name == BODY else f"{channel.name}/"


cdef object _number(double value):
    """Return a number, None for NaN."""
    return None if isnan(value) else value


cdef object _key_frame(Channel channel, Event* event):
    return KeyFrameEvent(
        v=SCHEMA_VERSION,  # its default is made by a call
        performer=channel.performer, id=f"{channel.prefix}{event.id}", rev=event.rev,
        status=KEY_FRAME_STATUSES[event.status], decided=event.decided == 1, kind=KEY_FRAME_KINDS[event.nature],
        take=event.take, frame=event.frame, time=event.time, decided_frame=event.until_frame,
        decided_time=event.until_time, velocity=event.velocity, strength=_number(event.strength), channel=channel.name,
    )


cdef object _segment(Channel channel, Event* event):
    cdef int64_t* joints = &event.joint0
    cdef int64_t count = 0
    while count < PATH_JOINTS and joints[count] != NO_JOINT:
        count += 1
    return SegmentEvent(
        v=SCHEMA_VERSION,
        performer=channel.performer, id=f"{channel.prefix}{event.id}-{event.end_id}", rev=event.rev,
        status=SEGMENT_STATUSES[event.status], state=SEGMENT_STATES[event.nature], take=event.take,
        start_frame=event.frame, end_frame=event.until_frame, start_time=event.time, end_time=event.until_time,
        active_joints=tuple([channel.joints[joints[i]] for i in range(count)]), similarity=_number(event.strength),
        active_start=event.active_start if event.nature else None,
        active_end=event.active_end if event.nature else None,
        channel=channel.name, limb=_limb_that_leads(channel.limbs, joints, count) if channel.limbs else None,
    )


cdef object _limb_that_leads(tuple limbs, int64_t* joints, int64_t count):
    """Return the limb that most of these joints belong to, the first ones counting most; as `moves.groups.leading_limb`."""
    cdef dict votes = {}
    cdef int64_t i
    best = None
    for i in range(count):
        limb = limbs[joints[i]]
        if limb is not None:
            votes[limb] = votes.get(limb, 0.0) + 1.0 / (i + 1)
    for limb in votes:
        if best is None or votes[limb] > votes[best]:
            best = limb
    return best


cdef object _activity(Channel channel, Event* event):
    """Return the event of a change between moving and resting, which is rare."""
    return ActivityEvent(
        performer=channel.performer, id=f"{channel.performer}/{_of_limb(channel)}activity/{event.take}/{event.id}",
        take=event.take, state=SEGMENT_STATES[event.nature], start=event.time, previous=_number(event.strength),
        limb=channel.limbs[event.joint0] if channel.limbs and event.joint0 >= 0 else None,
        decided_time=event.until_time, channel=channel.name,
    )
