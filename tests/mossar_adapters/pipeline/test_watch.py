from mossar_adapters.pipeline.watch import Watch


def test_a_stall_is_found_once_after_0_3_s_and_the_end_of_the_take_after_the_pause():
    watch = Watch(lambda _: 1.0)
    watch.heard("p1", 0, now=10.0)
    assert watch.check(10.29) == []
    assert watch.check(10.31) == [("p1", "stalled")]
    assert watch.check(10.9) == []
    assert watch.check(11.01) == [("p1", "ended")]
    assert watch.check(20.0) == []


def test_frames_after_a_stall_are_a_return():
    watch = Watch(lambda _: 1.0)
    assert watch.heard("p1", 0, now=0.0) is False
    watch.check(0.5)
    assert watch.heard("p1", 0, now=0.6) is True
    assert watch.heard("p1", 0, now=0.7) is False
    assert watch.check(1.1) == [("p1", "stalled")]


def test_for_what_waits_in_a_queue_time_stands_still():
    watch = Watch(lambda _: 1.0)
    watch.heard("p1", 0, now=0.0)
    watch.heard("p2", 1, now=0.0)
    assert watch.check(0.5, {0: 0.2}) == [("p2", "stalled")]
    assert watch.check(0.6, {0: 0.4}) == [("p1", "stalled")]


def test_somebody_who_has_left_is_missed_although_others_keep_the_queue_full():
    watch = Watch(lambda _: 1.0)
    watch.heard("p1", 0, now=0.0)
    found = []
    for k in range(1, 21):
        watch.heard("p2", 0, now=k / 10)
        found += watch.check(k / 10 + 0.05, {0: k / 10 + 0.01})
    assert found == [("p1", "stalled"), ("p1", "ended")]


def test_performers_of_a_source_that_ended_are_not_missed():
    watch = Watch(lambda _: 1.0)
    watch.heard("p1", 0, now=0.0)
    watch.heard("p2", 1, now=0.0)
    watch.forget(0)
    assert watch.check(5.0) == [("p2", "stalled"), ("p2", "ended")]


def test_frames_that_arrived_before_the_stall_are_no_return():
    watch = Watch(lambda _: 1.0)
    watch.heard("p1", 0, now=10.0)
    assert watch.check(10.4) == [("p1", "stalled")]
    assert watch.heard("p1", 0, now=10.65, came=10.01) is False
    assert watch.check(10.7) == []  # it is stalled already
    assert watch.check(11.1) == [("p1", "ended")]
    assert watch.heard("p1", 0, now=12.0, came=11.99) is True
