"""Tiers as events of C3D files, and back."""

from pathlib import Path

import pytest

from checks.fuzz.recordings import c3d
from mossar_adapters.annotations.c3d import write_c3d_events
from mossar_adapters.annotations.reading import chosen_tier, read_annotations
from mossar_adapters.annotations.tiers import AnnotationError, Mark, Tier

TIERS = [
    Tier("key frames", (Mark(0.1, 0.1, "onset"), Mark(0.3, 0.3, "offset")), moments=True),
    Tier("steps", (Mark(0.15, 0.15, "left strike"), Mark(0.2, 0.2, "right off")), moments=True),
    Tier("repetitions", (Mark(0.0, 0.2, "1"), Mark(0.2, 0.4, "2"))),
    Tier("left_arm repetitions", (Mark(0.0, 0.25, "1"),)),
    Tier("moves", (Mark(0.1, 0.4, "high kick"),)),
]


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    path = tmp_path / "take.c3d"
    path.write_bytes(c3d(30, first=50))
    return path


def test_tiers_are_read_back_from_the_events_of_a_trimmed_recording(recording: Path) -> None:
    copy = recording.with_name("copy.c3d")
    assert write_c3d_events(str(recording), copy, [*TIERS, Tier("segments", (Mark(0, 1, "moving"),))]) == 12
    back = {tier.name: tier for tier in read_annotations(str(copy))}
    assert set(back) == {tier.name for tier in TIERS}
    for tier in TIERS:
        assert [mark.label for mark in back[tier.name].marks] == [mark.label for mark in tier.marks]
        for end in ("start", "end"):
            times = [getattr(mark, end) for mark in tier.marks]
            assert [getattr(mark, end) for mark in back[tier.name].marks] == pytest.approx(times, abs=1e-5)
        assert back[tier.name].moments == tier.moments


def test_gait_events_of_other_programs_are_steps(shared_data: Path) -> None:
    tier = chosen_tier(shared_data / "formats" / "c3d" / "gait_13_events.c3d", None, ())
    assert (tier.name, len(tier.marks)) == ("steps", 13)
    assert tier.marks[1].label == "right strike"
    assert tier.marks[1].start == pytest.approx(2.89 - 2.48, abs=1e-6)


def test_a_recording_without_events_holds_no_annotations(recording: Path) -> None:
    with pytest.raises(AnnotationError, match="no events"):
        read_annotations(recording)


@pytest.mark.parametrize("content", [b"", b"x" * 2000, c3d(30)[:700]])
def test_damaged_recordings_are_refused_in_one_line(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "bad.c3d"
    path.write_bytes(content)
    with pytest.raises(AnnotationError, match=r"bad\.c3d") as caught:
        read_annotations(path)
    assert "\n" not in str(caught.value)


def test_events_go_into_copies_of_c3d_files_only(recording: Path) -> None:
    with pytest.raises(AnnotationError, match=r"walk\.bvh is none"):
        write_c3d_events("walk.bvh", recording.with_name("b.c3d"), TIERS)
    with pytest.raises(AnnotationError, match="the recording itself"):
        write_c3d_events(str(recording), recording, TIERS)
