"""What comes from outside does nothing to a terminal, and stays what it is otherwise."""

import json
import os

import numpy as np
import pytest

from mossar_adapters.address import parse_url
from mossar_adapters.files import FileError, open_recording
from mossar_adapters.files.msk import MskWriter
from mossar_adapters.joint_sets import printable_names
from mossar_adapters.maps.codec import to_json
from mossar_adapters.maps.frame_maps import FrameMap, MetaMap
from mossar_adapters.maps.lines import LineDecoder
from mossar_adapters.osc.datagrams import Datagram
from mossar_adapters.osc.decoder import OscDecoder
from mossar_adapters.osc.encode import encode
from mossar_adapters.pipeline import Pipeline, Upkeep, read_snapshot
from mossar_adapters.source import Meta
from mossar_adapters.urls import open_sink, open_source
from mossar_stream import Frames, Skeleton

NASTY = ("hip\x1b[2J", "hand\r\n", "foot\x9b")


def clean(names):
    return all(name.isprintable() for name in names) and len(set(names)) == len(names)


def test_names_that_become_alike_stay_apart():
    names = printable_names(Skeleton(("a\x1b", "a\r", "a_", "a\n"))).names
    assert clean(names)
    assert names[2] == "a_"
    assert printable_names(Skeleton(("x" * 127 + "\x1b", "x" * 127 + "\r"))).names[0].isprintable()


def test_joint_names_of_every_wire_and_file_are_printable(tmp_path):
    lines = LineDecoder()
    (meta,) = lines.receive(to_json(MetaMap(NASTY)) + b"\n", 0.0)
    assert clean(meta.skeleton.names)
    osc = OscDecoder(parse_url("osc://127.0.0.1:0"))
    (meta,) = osc.receive(Datagram(encode("/mossar/meta", "ssss", "ann", *NASTY), "127.0.0.1", 9, 0.0))
    assert clean(meta.skeleton.names)
    with MskWriter(tmp_path / "take.msk") as writer:
        writer.write(Meta("p1", Skeleton(NASTY)))
        writer.write(Frames(np.ones((3, 3, 3), np.float32), np.arange(3) / 30))
    assert clean(open_recording(tmp_path / "take.msk").skeleton.names)
    (tmp_path / "take.jsonl").write_bytes(
        to_json(MetaMap(NASTY)) + b"\n" + to_json(FrameMap(t=0.0, xyz=[[0.0, 1.0, 0.0]] * 3)) + b"\n"
    )
    assert clean(open_recording(tmp_path / "take.jsonl").skeleton.names)


@pytest.mark.skipif(os.name != "posix", reason="file names are bytes on POSIX systems")
def test_a_file_name_that_is_no_utf_8_is_read_written_and_kept_in_a_snapshot(tmp_path):
    take, events, state = (
        os.fsdecode(os.fsencode(tmp_path) + name) for name in (b"/t\xff.msk", b"/e\xff.jsonl", b"/s")
    )
    with MskWriter(take) as writer:
        writer.write(Meta("p1", Skeleton(("hip", "hand"), (-1, 0))))
        writer.write(Frames(np.random.default_rng(1).random((90, 2, 3), np.float32), np.arange(90) / 30))
    from pathlib import Path

    outcome = Pipeline([open_source(take)], [open_sink(events)], upkeep=Upkeep(snapshot=Path(state))).run()
    assert (outcome.errors, outcome.dead_sinks, outcome.frames) == ([], [], 90)
    assert json.loads(Path(events).read_bytes().splitlines()[0])["event"] == "started"
    snapshot = read_snapshot(Path(state))
    assert list(snapshot.sinks) == [f"{tmp_path}/e\ufffd.jsonl"]
    assert snapshot.sources[0].name == f"{tmp_path}/t\ufffd.msk"
    with pytest.raises(FileError, match=r"missing\ufffd\.msk: cannot be opened"):
        open_recording(os.fsdecode(os.fsencode(tmp_path) + b"/missing\xff.msk"))
