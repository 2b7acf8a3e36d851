"""The job on a real engine: killed, restarted, rescaled. Needs the extra `flink` and Java; see `.ci/run`."""

import time

import pytest

from mossar_adapters.flink.records import records_of

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
    assert job.latest_checkpoint() is None, "what is over leaves nothing to go on from"


def test_files_hold_every_event_exactly_once_after_kill_9(work, flink, crowd):
    lines, expected = crowd
    total = sum(map(len, expected.values()))
    job = work(lines, 'files = "events"')
    job.run_and_kill(0.3, total)
    assert 0 < job.count() < total
    job.run()
    assert flink.by_performer(job.lines(), repeats=False) == expected


def test_records_that_cannot_be_used_stop_nothing(work, flink):
    people = flink.generated(2, 5)
    lines = flink.interleaved(people).splitlines(keepends=True)
    bad = [
        b"nothing\n",
        b'{"type":"frames"\n',
        b'{"type":"frames","performer":"g0","t":[1],"shape":[1,2,3],"xyz":""}\n',
    ]
    for place, line in zip((0, 5, 20), bad, strict=True):
        lines.insert(place, line)
    job = work(b"".join(lines))
    job.run()
    assert flink.by_performer(job.lines(), repeats=False) == flink.direct(people)
    assert list(job.folder.glob("checkpoints/*/ended")), "the run is marked as ended"
    assert job.latest_checkpoint() is None


def test_a_job_that_cannot_send_says_why_in_one_line(work, flink):
    job = work(flink.interleaved(flink.generated(1, 1)), 'live = "zmq://no.such.host.invalid:1"')
    process = job.start()
    _, messages = process.communicate(timeout=600)
    assert process.returncode == 1
    starting, error = messages.decode().splitlines()
    assert starting.startswith("mossar: starting Flink")
    assert error.startswith("mossar: error: the Flink job failed: zmq://no.such.host.invalid:1: the host")


@pytest.mark.parametrize("table", ["source", "to"])
def test_a_missing_kafka_connector_is_said(work, table):
    job = work(b"", 'live = "-"')
    kafka = 'kafka = { servers = "127.0.0.1:1", topic = "t" }'
    job.write(source=kafka) if table == "source" else job.write(to=kafka)
    process = job.launch()
    _, messages = process.communicate(timeout=600)
    assert process.returncode == 2
    assert b"the Kafka connector is missing: put flink-sql-connector-kafka" in messages


def test_the_take_of_who_stops_sending_ends_and_who_stays_away_is_forgotten(heard_live, flink):
    ((meta, frames),) = flink.generated(1, 2)
    sent, forget = [*records_of(meta, text=True), *records_of(frames, text=True)], 3.0
    with heard_live(idle=1.0, forget=forget) as (send, hear):
        send(sent)
        first = hear(until="ended")
        assert [(event["event"], event["take"], event["reason"]) for event in first] == [
            ("started", 0, ""),
            ("ended", 0, "gap"),
        ]
        send(sent)  # the state was kept: another take
        assert [(event["event"], event["take"]) for event in hear(until="ended")] == [
            ("started", 1),
            ("ended", 1),
        ]
        time.sleep(forget + 0.5)
        send(sent)  # it was not: as if never heard of
        assert [(event["event"], event["take"]) for event in hear(until="ended")] == [
            ("started", 0),
            ("ended", 0),
        ]
