import numpy as np
import pytest

from mossar_adapters.address import parse_url
from mossar_adapters.files import read
from mossar_adapters.osc.datagrams import Datagram
from mossar_adapters.osc.decoder import OscDecoder
from mossar_adapters.osc.encode import bundle, encode
from mossar_adapters.source import Meta
from mossar_stream import Frames

# Metres.
BODY = {
    "Head": (0, 1.7, 2),
    "Neck": (0, 1.5, 2),
    "Torso": (0, 1.2, 2),
    "Right_Shoulder": (-0.2, 1.45, 2),
    "Right_Elbow": (-0.3, 1.2, 2),
    "Right_Hand": (-0.35, 0.95, 2),
    "Left_Foot": (0.1, 0.05, 2),
}
FPS = 30


def shifted(frame, unit=1.0):
    return {name: (x * unit, (y + frame * 0.01) * unit, z * unit) for name, (x, y, z) in BODY.items()}


def heard(frames, decoder=None, *, together=False):
    """Return the items that datagrams give; `frames` are lists of messages."""
    decoder = decoder or OscDecoder(parse_url("osc://127.0.0.1:0"))
    items = []
    for k, messages in enumerate(frames):
        for data in [bundle(messages)] if together else messages:
            items += decoder.receive(Datagram(data, "127.0.0.1", 9000, k / FPS))
        items += decoder.idle(k / FPS + 0.01)
    return items + decoder.idle(k / FPS + 5) + decoder.end(), decoder


def basic(count, *, suffixes=("",), unit=1.0, sync=True):
    for k in range(count):
        frame = [
            encode(name + suffix, "fff", *map(float, place))
            for suffix in suffixes
            for name, place in shifted(k, unit).items()
        ]
        yield [*frame, encode("/NI_mate_sync", "f", 1.0)] if sync else frame


def poses(items, performer="p1"):
    return np.concatenate(
        [item.positions for item in items if isinstance(item, Frames) and item.performer == performer]
    )


@pytest.mark.parametrize("together", [False, True])
@pytest.mark.parametrize("sync", [False, True])
@pytest.mark.parametrize("unit", [1.0, 1000.0])
def test_addresses_without_a_slash_are_joints_in_metres(unit, sync, together):
    items, decoder = heard(basic(20, unit=unit, sync=sync), together=together)
    meta = next(item for item in items if isinstance(item, Meta))
    assert meta.skeleton.names == tuple(BODY)
    assert meta.skeleton.names[meta.skeleton.root] == "Torso"
    assert meta.skeleton.parents[0] == 1, "the head hangs on the neck"
    expected = [list(shifted(k).values()) for k in range(20)]
    assert poses(items) == pytest.approx(np.array(expected), abs=1e-5)
    assert decoder.counters.malformed == decoder.counters.ignored == 0


def test_several_users_have_numbers():
    items, _ = heard(basic(10, suffixes=("_1", "_2")))
    assert {item.performer for item in items} == {"p1", "p2"}
    assert [len(poses(items, name)) for name in ("p1", "p2")] == [10, 10]


@pytest.mark.parametrize("form", ["{}", "/skeleton_{}"])
@pytest.mark.parametrize("suffixes", [("", "_1"), ("", "_2"), ("", "_1", "_2"), ("_1", "_2", "_3")])
def test_the_first_of_several_users_may_have_no_number(form, suffixes):
    frames = [
        [
            encode(form.format(name + suffix), "fff", x + user, y, z)
            for user, suffix in enumerate(suffixes)
            for name, (x, y, z) in shifted(k).items()
        ]
        for k in range(10)
    ]
    items, _ = heard(frames)
    assert {item.performer for item in items} == {f"p{user + 1}" for user in range(len(suffixes))}
    for user in range(len(suffixes)):
        assert poses(items, f"p{user + 1}").shape == (10, len(BODY), 3)
        assert poses(items, f"p{user + 1}")[:, 0, 0] == pytest.approx(float(user), abs=1e-5)


def test_the_mark_ends_a_frame_in_which_joints_are_lost():
    frames = list(basic(20))
    for k in range(5, 20, 2):
        del frames[k][-4:-1]
    found = poses(heard(frames)[0])
    assert len(found) == 20
    lost = np.isnan(found).any(axis=2).sum(axis=1)
    assert lost.tolist() == [3 if k >= 5 and k % 2 else 0 for k in range(20)]


def test_the_mark_ends_a_frame_that_comes_slowly():
    """A pause between the joints of a frame is no end."""
    decoder, items = OscDecoder(parse_url("osc://127.0.0.1:0")), []
    now = 0.0
    for k, messages in enumerate(basic(20)):
        # Another one is lost.
        messages = [data for i, data in enumerate(messages) if i != (k if k > 3 else -1)]
        for data in messages:
            now += 0.06 if data is messages[2] else 0.001
            items += decoder.idle(now)
            items += decoder.receive(Datagram(data, "127.0.0.1", 9000, now))
    assert len(poses(items + decoder.end())) == 20


def test_other_values_without_a_slash_are_passed_over():
    frames = [
        [encode("Volume", "f", 0.5), encode("Head_rotation", "ffff", 0.0, 0.0, 0.0, 1.0), *messages]
        for messages in basic(5)
    ]
    items, _ = heard(frames)
    assert next(item for item in items if isinstance(item, Meta)).skeleton.names == tuple(BODY)


def test_an_orientation_may_follow():
    frames = [
        [
            encode(name, "fffffff", *map(float, place), 0.0, 0.0, 0.0, 1.0)
            for name, place in shifted(k).items()
        ]
        for k in range(5)
    ]
    assert poses(heard(frames)[0]).shape == (5, len(BODY), 3)


@pytest.mark.parametrize(
    "data",
    [b"hello world", b"Head\0\0\0,fff", b"Head\0\0,f\0\0\0\0\0\0", b"A" * 400, b"12\0\0,f\0\0\0\0\0\0"],
)
def test_other_bytes_without_a_slash_are_malformed(data):
    decoder = OscDecoder(parse_url("osc://127.0.0.1:0"))
    assert decoder.receive(Datagram(data, "127.0.0.1", 9000, 0.0)) == []
    assert decoder.counters.malformed == 1


def test_a_log_has_addresses_without_a_slash(tmp_path):
    rows = []
    for k in range(30):
        stamp = f"e8754700.{int(k / FPS * 2**32) & 0xFFFFFFFF:08x}"
        rows += [f"{stamp} {name} fff {x:.6f} {y:.6f} {z:.6f}" for name, (x, y, z) in shifted(k).items()]
        rows.append(f"{stamp} /NI_mate_sync f 1.000000")
    path = tmp_path / "take.osc"
    path.write_text("\n".join(rows) + "\n")
    take = read(path)
    assert take.skeleton.names == tuple(BODY)
    assert take.positions.shape == (30, len(BODY), 3)
