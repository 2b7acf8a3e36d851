import logging
import socket

import numpy as np
import pytest

from mossar_adapters.files.options import ReadOptions
from mossar_adapters.receiving.selection import SelectedSource
from mossar_adapters.source import Departure, Meta
from mossar_adapters.urls import open_frame_sink, open_sink, open_source
from mossar_stream import FrameError, Frames, MossarError, Skeleton


def frames_of(source):
    return [item for item in source.items() if isinstance(item, Frames)]


def test_the_built_in_performer_opens_by_url():
    source = open_source("demo:?seconds=0.5&seed=3")
    assert sum(map(len, frames_of(source))) == 30


def test_a_recording_opens_by_path_and_comes_whole(tmp_path):
    path = tmp_path / "take.msk"
    sink = open_frame_sink(str(path))
    items = list(open_source("demo:?seconds=1").items())
    for item in items:
        if isinstance(item, Meta):
            sink.announce(item)
        else:
            sink.send_frames(item)
    sink.close()
    read = frames_of(open_source(str(path)))
    sent = [item for item in items if isinstance(item, Frames)]
    assert np.array_equal(
        np.concatenate([f.positions for f in read]), np.concatenate([f.positions for f in sent])
    )
    assert np.array_equal(np.concatenate([f.times for f in read]), np.concatenate([f.times for f in sent]))


def test_joints_and_root_can_be_chosen_on_a_live_source():
    options = ReadOptions(joints=("Hips", "Head"), root="Head")
    items = list(open_source("demo:?seconds=0.2", options=options).items())
    assert items[0].skeleton.names == ("Hips", "Head")
    assert items[0].skeleton.root == 1
    assert items[1].positions.shape[1:] == (2, 3)


def test_a_root_that_is_not_among_the_joints_is_refused_and_a_centre_that_is_not_is_told(caplog):
    with pytest.raises(FrameError, match="the root Hips is not among the joints Head, Neck; add it"):
        list(
            open_source(
                "demo:?seconds=0.2", options=ReadOptions(joints=("Head", "Neck"), root="Hips")
            ).items()
        )
    with caplog.at_level(logging.INFO, "mossar"):
        list(open_source("demo:?seconds=0.2", options=ReadOptions(joints=("Head", "Neck"))).items())
    assert "Hips, is not among the joints; Neck is taken for it" in caplog.text


def test_a_newcomer_without_the_joints_is_left_out_and_the_others_go_on(caplog):
    class Two:
        name, live = "two", True

        def items(self):
            for name, joints in (("p1", ("hip", "head")), ("p2", ("hip", "tail"))):
                yield Meta(name, Skeleton(joints, (-1, 0)))
                yield Frames(np.zeros((1, 2, 3), np.float32), np.zeros(1), performer=name)
            yield Departure("p2", "gone")
            yield Departure("p1", "gone")

    found = list(SelectedSource(Two(), ReadOptions(joints=("hip", "head"))).items())
    assert [type(item).__name__ for item in found] == ["Meta", "Frames", "Departure"]
    assert "two: p2 is left out: no joint called 'head'" in caplog.text


def test_one_performer_of_several_can_be_chosen():
    source = open_source("demo:?seconds=0.2&performers=3", options=ReadOptions(performer="p2"))
    assert {item.performer for item in source.items() if item is not None} == {"p2"}


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("foo://x:1", "no scheme foo:; there are demo:, osc:, zmq:"),
        ("osc://127.0.0.1", "a port is missing"),
        ("osc://127.0.0.1:0?profil=vmc", "no option 'profil'; there are: profile"),
        ("osc://127.0.0.1:0?profile=kinect", "one of auto, mossar, vmc"),
        ("osc://127.0.0.1:0?fps=-3", "fps must lie in"),
        ("osc://127.0.0.1:0?unit=feet", "unit must be auto, m"),
        ("osc://127.0.0.1:0?allow=here", "IP numbers"),
        ("osc://127.0.0.1:0?profile=generic", "needs pattern="),
        ("osc://127.0.0.1:0?profile=generic&pattern=/a/{x}&args=xyz", "not {x}"),
        ("osc://127.0.0.1:0?profile=generic&pattern=/a&args=xyz", "joint's name"),
        ("osc://no.such.host.invalid:9000", "cannot be found"),
        ("zmq://no.such.host.invalid:9000", "cannot be found"),
        ("zmq://127.0.0.1:9000/path", "no path"),
        ("osc://192.0.2.1:9000", "not an address of this computer"),
        ("ws://127.0.0.1:1", "cannot be read from"),
        ("nowhere.bvh", "cannot be opened"),
        ("nowhere.xyz", "cannot be opened"),
    ],
)
def test_wrong_sources_are_refused_in_one_line(url, message):
    with pytest.raises(MossarError) as caught:
        open_source(url)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("events.doc", "events go to .jsonl"),
        ("events.msk", "mossar record"),
        ("/no/such/folder/events.jsonl", "cannot be written"),
        ("demo:", "takes no events"),
        ("osc://no.such.host.invalid:9000", "cannot be found"),
        ("osc://127.0.0.1:9000?profile=vmc", "no option 'profile'"),
        ("zmq+bind://127.0.0.1:0?encoding=xml", "one of msgpack, json"),
        ("ws://127.0.0.1:0/path", "no path"),
    ],
)
def test_wrong_sinks_are_refused_in_one_line(url, message):
    with pytest.raises(MossarError) as caught:
        open_sink(url)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("scheme", ["osc", "zmq+bind"])
def test_a_port_in_use_is_named(scheme):
    kind = socket.SOCK_DGRAM if scheme == "osc" else socket.SOCK_STREAM
    with socket.socket(socket.AF_INET, kind) as taken:
        taken.bind(("127.0.0.1", 0))
        if kind == socket.SOCK_STREAM:
            taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(MossarError, match=f"port {port} is in use"):
            open_source(f"{scheme}://127.0.0.1:{port}")


ONE = Frames(np.ones((1, 2, 3), np.float32), np.zeros(1), None, "p1")


@pytest.mark.parametrize("name", ["take.msk", "take.jsonl"])
def test_a_recording_is_not_replaced_unless_forced_and_frames_come(tmp_path, name):
    path = tmp_path / name
    written(str(path))
    before = path.read_bytes()
    with pytest.raises(MossarError, match="--force"):
        open_frame_sink(str(path))
    sink = open_frame_sink(str(path), force=True)
    sink.announce(Meta("p2", Skeleton(("a", "b"))))
    sink.close()
    assert path.read_bytes() == before
    written(str(path), force=True)


def written(path, **how):
    sink = open_frame_sink(path, **how)
    sink.announce(Meta("p1", Skeleton(("hip", "head"))))
    sink.send_frames(ONE)
    sink.close()
    sink.close()
    assert open_source(path).recording.skeleton.names == ("hip", "head")


@pytest.mark.parametrize("place", ["none/take.msk", "folder.msk"])
def test_a_recording_that_cannot_be_written_is_refused_before_frames_come(tmp_path, place):
    (tmp_path / "folder.msk").mkdir()
    with pytest.raises(MossarError, match="cannot be written: "):
        open_frame_sink(str(tmp_path / place), force=True)


def test_a_recording_to_which_nothing_comes_leaves_no_file(tmp_path):
    sink = open_frame_sink(str(tmp_path / "take.msk"))
    sink.announce(Meta("p1", Skeleton(("hip", "head"))))
    sink.close()
    assert list(tmp_path.iterdir()) == []
