from mossar_adapters.pipeline.watch import Watch


def test_a_stall_is_found_once_after_0_3_s_and_the_end_of_the_take_after_the_pause():
    watch = Watch()
    watch.heard(now=10.0)
    assert watch.check(10.29, 1.0) == []
    assert watch.check(10.31, 1.0) == ["stalled"]
    assert watch.check(10.9, 1.0) == []
    assert watch.check(11.01, 1.0) == ["ended"]
    assert watch.check(20.0, 1.0) == []


def test_a_long_silence_is_a_stall_and_the_end_of_the_take_at_once():
    watch = Watch()
    watch.heard(now=10.0)
    assert watch.check(12.0, 1.0) == ["stalled", "ended"]


def test_frames_after_a_stall_are_a_return():
    watch = Watch()
    assert watch.heard(now=0.0) is False
    watch.check(0.5, 1.0)
    assert watch.heard(now=0.6) is True
    assert watch.heard(now=0.7) is False
    assert watch.check(1.1, 1.0) == ["stalled"]


def test_a_performer_whose_frames_never_came_or_who_left_is_not_missed():
    watch = Watch()
    assert watch.check(5.0, 1.0) == []
    watch.heard(now=6.0)
    watch.check(6.5, 1.0)
    watch.leave()
    assert watch.check(20.0, 1.0) == []
    assert watch.heard(now=21.0) is False


def test_frames_that_arrived_before_the_stall_are_no_return():
    watch = Watch()
    watch.heard(now=10.0)
    assert watch.check(10.4, 1.0) == ["stalled"]
    assert watch.heard(now=10.65, came=10.01) is False
    assert watch.check(10.7, 1.0) == []  # it is stalled already
    assert watch.check(11.1, 1.0) == ["ended"]
    assert watch.heard(now=12.0, came=11.99) is True
