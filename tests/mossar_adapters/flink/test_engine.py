"""The job on a real engine: killed, restarted, rescaled. Needs the extra `flink` and Java; see `.ci/run`."""

import pytest

pytest.importorskip("pyflink", reason="the extra flink is not installed (its own environment, see .ci/run)")


@pytest.mark.parametrize("parallelism", [1, 2])
def test_after_kill_9_and_restart_the_events_are_those_of_direct_runs(work, flink, crowd, parallelism):
    lines, expected = crowd
    total = sum(map(len, expected.values()))
    job = work(lines)
    job.run_and_kill(0.3, total)
    before = job.count()
    assert "going on from the checkpoint" in job.run(parallelism)
    found = job.lines()
    assert 0 < before < total <= len(found)
    assert len(found) < before + total, "it went on in the middle instead of beginning anew"
    assert flink.by_performer(found, repeats=True) == expected
    assert not job.checkpoints(), "what is over leaves nothing to go on from"


def test_files_hold_every_event_exactly_once_after_kill_9(work, flink, crowd):
    lines, expected = crowd
    total = sum(map(len, expected.values()))
    job = work(lines, 'files = "events"')
    job.run_and_kill(0.3, total)
    assert 0 < job.count() < total
    job.run()
    assert flink.by_performer(job.lines(), repeats=False) == expected
