"""The decoder by itself: no socket, no clock but the arrivals that the tests give."""

import numpy as np
import pytest

from mossar_adapters.address import parse_url
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.joint_sets import KINECT_25
from mossar_adapters.osc.datagrams import Datagram
from mossar_adapters.osc.decoder import OscDecoder
from mossar_adapters.osc.encode import bundle, encode
from mossar_adapters.source import Departure, Meta
from mossar_stream import Frames

JOINTS = ("head", "neck", "torso", "l_shoulder", "l_elbow", "l_hand", "r_shoulder", "r_elbow", "r_hand")
BONES = ("Hips", "Spine", "Head", "LeftHand", "RightHand")
STEP = 1 / 30  # s between frames
BETWEEN = 1e-4  # s between the messages of a frame


def decoder(query="", **options):
    return OscDecoder(parse_url(f"osc://127.0.0.1:0{query}"), ReadOptions(**options))


def at(arrival, address, tags="", *arguments, host="127.0.0.1", port=9000):
    return Datagram(encode(address, tags, *arguments), host, port, arrival)


def upright(joint, frame):
    return (0.5 + 0.01 * joint, 0.1 + 0.1 * joint, 2.0 + 0.001 * frame)


def osceleton(frame, user=1, without=()):
    return [
        at(frame * STEP + i * BETWEEN, "/joint", "sifff", name, user, *upright(i, frame))
        for i, name in enumerate(JOINTS)
        if i not in without
    ]


def vmc(frame):
    bones = [
        at(
            frame * STEP + i * BETWEEN,
            "/VMC/Ext/Bone/Pos",
            "sfffffff",
            bone,
            0,
            0.1 * i,
            0.01 * frame,
            0,
            0,
            0,
            1,
        )
        for i, bone in enumerate(BONES)
    ]
    end = frame * STEP + len(BONES) * BETWEEN
    return [*bones, at(end, "/VMC/Ext/OK", "i", 1), at(end, "/VMC/Ext/T", "f", frame / 30)]


def kinect(frame):
    return [
        at(
            frame * STEP + i * BETWEEN,
            f"/bodies/7/joints/{name}",
            "fffs",
            0.1 * i,
            1.0,
            2.0 + frame,
            "Tracked",
        )
        for i, name in enumerate(KINECT_25.names)
    ]


def ours(frame):
    blob = np.full((4, 3), frame, ">f4").tobytes()
    meta = [at(0.0, "/mossar/meta", "sssss", "ann", "hip", "knee", "foot", "head")] if frame == 0 else []
    return [*meta, at(frame * STEP, "/mossar/frame", "sidb", "ann", frame, frame / 30, blob)]


def flat(frame):
    return [at(frame * STEP, "/pose", "f" * 51, *(0.01 * i + 0.001 * frame for i in range(51)))]


SENDERS = {"osceleton": osceleton, "vmc": vmc, "kinect": kinect, "mossar": ours, "flat": flat}


def decoded(datagrams, size, osc=None):
    """Return what comes of datagrams that are handed over `size` at a time, and of the quiet after them."""
    osc = osc or decoder()
    found = []
    for i in range(0, len(datagrams), size):
        found += osc.receive(*datagrams[i : i + size])
    if osc.pending:
        found += osc.idle(datagrams[-1].arrival + 10)
    assert not osc.pending
    return found


def joined(items):
    """Return metas, and the frames of each performer in one piece."""
    metas = [item for item in items if isinstance(item, Meta)]
    frames = {}
    for item in items:
        if isinstance(item, Frames):
            frames.setdefault(item.performer, []).append(item)
    return metas, {
        name: (np.concatenate([f.positions for f in found]), np.concatenate([f.times for f in found]))
        for name, found in frames.items()
    }


@pytest.mark.parametrize("sender", SENDERS)
@pytest.mark.parametrize("size", [1, 7, 64])
def test_datagrams_give_the_same_frames_however_they_are_handed_over(sender, size):
    datagrams = [datagram for frame in range(20) for datagram in SENDERS[sender](frame)]
    metas, whole = joined(decoded(datagrams, len(datagrams)))
    pieces_metas, pieces = joined(decoded(datagrams, size))
    assert pieces_metas == metas
    assert pieces.keys() == whole.keys() != set()
    for name, (positions, times) in whole.items():
        assert len(times) == 20
        assert np.array_equal(pieces[name][0], positions, equal_nan=True)
        assert np.array_equal(pieces[name][1], times)


def test_what_comes_together_is_one_chunk_for_each_performer():
    datagrams = [d for frame in range(10) for user in (1, 2) for d in osceleton(frame, user)]
    found = decoder(fps=30.0).receive(*datagrams)
    assert [(type(item).__name__, item.performer, getattr(item, "times", ())) for item in found[:2]] == [
        ("Meta", "p1", ()),
        ("Meta", "p2", ()),
    ]
    assert [(item.performer, len(item)) for item in found[2:]] == [("p1", 10), ("p2", 10)]


def test_a_lost_joint_is_missing_and_the_frames_after_it_are_whole():
    lost = {10: (0,), 15: (4,), 20: (8,)}
    datagrams = [d for frame in range(30) for d in osceleton(frame, without=lost.get(frame, ()))]
    positions, _ = joined(decoded(datagrams, 9))[1]["p1"]
    assert len(positions) == 30
    missing = np.argwhere(np.isnan(positions).any(axis=2))
    assert [tuple(pair) for pair in missing] == [(10, 0), (15, 4), (20, 8)]
    depth = np.nanmax(positions[:, :, 2], axis=1) - np.nanmin(positions[:, :, 2], axis=1)
    assert depth.max() < 1e-5, "no frame mixes joints of two"


def test_a_sender_met_in_mid_frame_is_in_step_after_two_frames():
    datagrams = [d for frame in range(12) for d in osceleton(frame, without=range(5) if frame == 0 else ())]
    positions, _ = joined(decoded(datagrams, 1))[1]["p1"]
    assert len(positions) == 12
    assert np.isfinite(positions[2:]).all()
    assert np.ptp(positions[2:, :, 2], axis=1).max() < 1e-5, "no frame mixes joints of two"


def test_who_leaves_comes_behind_the_last_frame():
    datagrams = [d for frame in range(3) for d in osceleton(frame, 3)]
    found = decoder().receive(*datagrams, at(0.2, "/lost_user", "i", 3))
    assert [type(item) for item in found] == [Meta, Frames, Departure]
    assert found[2] == Departure("p3", "lost user")


def test_frames_that_are_complete_are_not_lost_by_what_is_malformed_after_them():
    osc = decoder()
    good, bad = encode("/mossar/frame", "sidb", "ann", 1, 0.5, bytes(24)), encode("/joint", "si", "head", 1)
    cut = bundle([good, bad, good])[:-8]
    found = osc.receive(Datagram(cut, "10.0.0.7", 9000, 0.0), Datagram(b"rubbish", "10.0.0.7", 9000, 0.0))
    assert [len(item) for item in found if isinstance(item, Frames)] == [1]
    assert (osc.counters.received, osc.counters.malformed) == (2, 3)


def test_too_many_joints_in_one_message_change_nothing():
    osc = decoder("?profile=nimate", unit="m")
    many = [f"/skeleton_joint{i}" for i in range(250)]
    osc.receive(*(at(0.0, address, "fff", 1, 2, 3) for address in many))
    assert osc.receive(at(0.1, "/skeleton", "f" * 768, *range(768))) != []
    before = osc.counters.malformed
    assert osc.receive(at(0.2, "/skeleton_one_more", "fff", 1, 2, 3)) == []
    assert osc.counters.malformed == before + 1
    assert len(osc.receive(at(0.3, "/skeleton", "f" * 768, *range(768)))) == 1


def test_who_is_not_allowed_is_not_read():
    osc = decoder("?allow=10.0.0.0/8")
    frame = "/mossar/frame", "sidb", "ann", 1, 0.5, bytes(24)
    assert osc.receive(at(0.0, *frame, host="192.168.0.7")) == []
    assert len(osc.receive(at(0.0, *frame, host="10.1.2.3"))) == 2
    assert (osc.counters.received, osc.counters.ignored) == (2, 1)


def test_a_flood_of_ids_does_not_take_the_place_of_who_moves():
    osc, strangers = decoder(), 0
    frames = 0
    for frame in range(60):
        for datagram in osceleton(frame):
            flood = [
                at(datagram.arrival, "/joint", "sifff", "head", 1000 + strangers + k, 0, 0, 0)
                for k in range(20)
            ]
            strangers += len(flood)
            found = osc.receive(datagram, *flood)
            frames += sum(len(item) for item in found if isinstance(item, Frames) and item.performer == "p1")
            assert not any(isinstance(item, Meta) and item.performer == "p1" for item in found) or frames <= 2
    assert frames == 60
