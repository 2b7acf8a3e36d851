"""Out: the events of counted repetitions, and the revisions of those that a later analysis changes."""

from mossar_stream.events import PhaseEvent, RepetitionEvent


cdef int64_t total_of(Counting* counted) noexcept:
    """Return the number of repetitions in the take."""
    return counted.dropped + counted.cycles if counted.clear == 1 else 0


cdef object phase_of(Counting* counted, double time):
    """Return the phase at a time, s: 0 to 1 from the start of a cycle; None outside a bout."""
    cdef Cycle* cycle
    cdef double since, phase
    if counted.cycles == 0 or counted.clear == 0:
        return None
    cycle = &counted.cycle[counted.cycles - 1]
    since = time - counted.origin - cycle.ends
    if not since <= LONGEST_SILENCE * cycle.period + ANALYSIS_INTERVAL + STAMP_ROUNDING:
        return None
    phase = fmod(since / cycle.period, 1.0)
    return phase + 1.0 if phase < 0.0 else abs(phase)


cdef int report_repetitions(Channel channel, list pending) except -1:
    """Report a changed count: withdrawn repetitions, then new and changed ones."""
    cdef Counting* counted = counting_of(channel.row)
    cdef int64_t take = channel.row.clock.take, total = total_of(counted), standing, number
    if not channel.reports:
        return 0
    standing = min(channel.total, total)
    for number in range(channel.total, total, -1):
        pending.append(_repetition(channel, take, number, number - 1, True))
    for number in range(counted.dropped + counted.changed + 1, total + 1):
        pending.append(_repetition(channel, take, number, max(number, standing), False))
    channel.total = total
    channel.revisions = {known: rev for known, rev in channel.revisions.items() if known > counted.dropped}
    return 0


cdef int report_phase(Channel channel, list pending) except -1:
    """Report the phase of the latest frame once; outside a bout report only the first phase of None."""
    cdef double time = channel.row.clock.time
    phase = phase_of(counting_of(channel.row), time)
    if time != channel.phase_time and (phase is not None or channel.had_phase):
        pending.append(
            PhaseEvent(
                performer=channel.performer, take=channel.row.clock.take, channel=channel.name, time=time, phase=phase
            )
        )
    channel.phase_time, channel.had_phase = time, phase is not None
    return 0


cdef object _repetition(Channel channel, int64_t take, int64_t number, int64_t total, bint is_withdrawn):
    """Return the event of a repetition, with the next revision."""
    cdef Counting* counted = counting_of(channel.row)
    cdef Cycle* cycle = &counted.cycle[0 if is_withdrawn else number - counted.dropped - 1]
    cdef bint is_counted = not is_withdrawn, has_period = is_counted and not isnan(cycle.period)
    revision = channel.revisions[number] = channel.revisions.get(number, 0) + 1
    limb = "" if channel.name == BODY else f"{channel.name}/"
    return RepetitionEvent(
        performer=channel.performer, id=f"{channel.performer}/{limb}{take}/r{number}", rev=revision,
        status="counted" if is_counted else "withdrawn", take=take, channel=channel.name, total=total,
        decided_time=counted.latest, count=cycle.count if is_counted else 0,
        period=cycle.period if has_period else None, tempo=60.0 / cycle.period if has_period else None,
        start=counted.origin + cycle.begins if is_counted else None,
        end=counted.origin + cycle.ends if is_counted else None,
        amplitude=cycle.amplitude if is_counted else None, joint=channel.joints[cycle.joint] if is_counted else None,
    )
