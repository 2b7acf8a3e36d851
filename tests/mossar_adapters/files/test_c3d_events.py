"""Events of C3D files: written into a copy that differs in nothing else, and read back by other libraries."""

import numpy as np
import pytest

from mossar_adapters.files import FileError
from mossar_adapters.files.c3d_copy import C3dCopy, texts
from mossar_adapters.files.c3d_events import C3dEvent, read_events, write_events
from mossar_adapters.files.c3d_parameters import read_parameters, read_section, records

STRIKE = C3dEvent("Foot Strike", 0.25, "Left", 1, "heel", "anna")
NEW = [STRIKE, C3dEvent("Key Frame", 61.5, description="onset")]
# What a copy has to change: where the data begin, if the parameters need more blocks.
MAY_DIFFER = {"POINT:DATA_START"}


def same(one, other):
    return one == other if isinstance(one, list) else np.array_equal(one, other, equal_nan=True)


@pytest.mark.parametrize("machine", [84, 85, 86])
@pytest.mark.parametrize("count", [1, 2, 700])
def test_a_copy_has_the_events_and_every_byte_of_the_rest(sample, tmp_path, machine, count):
    source, copy = sample("c3d", machine=machine, labels=("hip", "knee", "foot", "Kopf")), tmp_path / "b.c3d"
    events = [C3dEvent("Key Frame", round(k / 64, 4)) for k in range(count)]
    assert write_events(source, copy, events) == count
    assert [event.time for event in read_events(copy)] == pytest.approx([e.time for e in events], abs=1e-5)
    before, after = source.read_bytes(), copy.read_bytes()
    (start, _, _), (moved, _, _) = read_section(source), read_section(copy)
    assert after[(moved.data_block - 1) * 512 :] == before[(start.data_block - 1) * 512 :]
    assert after[:16] + after[18:512] == before[:16] + before[18:512]
    old, new = read_parameters(source)[2], read_parameters(copy)[2]
    assert all(same(old[name], new[name]) for name in old)


def test_events_of_the_source_stay_and_those_that_are_there_are_not_added_again(sample, tmp_path):
    first, second = tmp_path / "1.c3d", tmp_path / "2.c3d"
    write_events(sample("c3d"), first, NEW)
    assert write_events(first, second, [*NEW, C3dEvent("Foot Off", 0.5, "Left", 2)]) == 1
    assert [event.label for event in read_events(second)] == ["Foot Strike", "Key Frame", "Foot Off"]
    assert read_events(second)[0] == STRIKE
    assert read_events(second)[1].time == pytest.approx(61.5)


def test_labels_may_be_written_in_any_language(sample, tmp_path):
    write_events(sample("c3d"), tmp_path / "b.c3d", [C3dEvent("Schläge " * 40, 0.1), C3dEvent("跳", 0.2)])
    long, short = read_events(tmp_path / "b.c3d")
    assert (long.label[:8], short.label) == ("Schläge ", "跳")
    assert len(long.label.encode()) <= 255


def real_files(shared):
    return sorted(path for path in (shared / "formats" / "c3d").iterdir() if path.stat().st_size)


def test_copies_of_real_files_are_those_files(shared, tmp_path):
    for source in real_files(shared):
        copy = tmp_path / "copy.c3d"
        write_events(source, copy, [C3dEvent("Key Frame", 0.1 * k) for k in range(300)])
        (old, machine, section), (new, _, written) = read_section(source), read_section(copy)
        place = {"EVENT"}
        parts = [
            {
                (r.group, r.name): part[r.begin : r.value - 2] + part[r.value : r.value - 2 + r.step]
                for r in records(part, machine)
            }
            for part in (section, written)
        ]
        groups = {-group: name for group, name in parts[0] if group < 0}
        for (group, name), content in parts[0].items():
            full = f"{groups.get(abs(group))}:{name}"
            if groups.get(abs(group)) not in place and full not in MAY_DIFFER and content:
                assert parts[1][group, name][: len(content)] == content, (source.name, full)
        data = source.read_bytes()[(old.data_block - 1) * 512 :]
        assert copy.read_bytes()[(new.data_block - 1) * 512 :] == data, source.name


def test_other_libraries_read_the_events_and_the_same_data(shared, tmp_path):
    ezc3d = pytest.importorskip("ezc3d")
    source, copy = shared / "formats" / "c3d" / "gait_13_events.c3d", tmp_path / "copy.c3d"
    assert write_events(source, copy, [C3dEvent("Key Frame", 3.25), C3dEvent("Key Frame", 4.5)]) == 2
    before, after = ezc3d.c3d(str(source)), ezc3d.c3d(str(copy))
    for kind in ("points", "analogs"):
        np.testing.assert_array_equal(after["data"][kind], before["data"][kind])
    events = after["parameters"]["EVENT"]
    assert int(events["USED"]["value"][0]) == 15
    assert events["LABELS"]["value"][-2:] == ["Key Frame", "Key Frame"]
    assert events["CONTEXTS"]["value"][0] == "Left"
    assert events["CONTEXTS"]["value"][-1] == "General"
    assert events["SUBJECTS"]["value"][-1] == "19290829m"
    np.testing.assert_allclose(events["TIMES"]["value"][1, -2:], [3.25, 4.5])
    np.testing.assert_array_equal(
        events["TIMES"]["value"][:, :13], before["parameters"]["EVENT"]["TIMES"]["value"]
    )


@pytest.mark.filterwarnings("ignore")
def test_kineticstoolkit_reads_the_events_on_the_clock_of_the_points(shared, tmp_path):
    ktk = pytest.importorskip("kineticstoolkit")
    source, copy = shared / "formats" / "c3d" / "gait_13_events.c3d", tmp_path / "copy.c3d"
    write_events(source, copy, [C3dEvent("Key Frame", 3.25)])
    points = ktk.read_c3d(str(copy), convert_point_unit=True)["Points"]
    assert ("Key Frame", 3.25) in [(event.name, float(event.time)) for event in points.events]
    assert points.time[0] == pytest.approx(2.48)


@pytest.mark.parametrize(
    ("name", "parameter", "match"),
    [
        ("TIMES", None, "2 events, but 0"),
        ("LABELS", None, "2 events, but 0"),
        ("LABELS", texts("LABELS", ["Foot Strike"]), "2 events, but 1"),
    ],
)
def test_events_that_lack_something_are_refused_in_one_line(sample, tmp_path, name, parameter, match):
    write_events(sample("c3d"), tmp_path / "b.c3d", NEW)
    damaged = C3dCopy(tmp_path / "b.c3d").remove("EVENT", [name])
    if parameter is not None:
        damaged.replace("EVENT", [parameter])
    damaged.write(tmp_path / "c.c3d")
    with pytest.raises(FileError, match=match):
        read_events(tmp_path / "c.c3d")


def test_a_file_without_events_has_none(sample):
    assert read_events(sample("c3d")) == []


def test_parameters_that_have_no_room_are_refused_and_nothing_is_written(sample, tmp_path):
    events = [C3dEvent("x" * 250, k / 10, description="y" * 250) for k in range(600)]
    with pytest.raises(FileError, match="at most 255"):
        write_events(sample("c3d"), tmp_path / "b.c3d", events)
    assert not (tmp_path / "b.c3d").exists()
