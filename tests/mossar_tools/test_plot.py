"""Pictures of recordings: what is thinned out, what is said of it, and where things lie."""

import itertools
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from mossar_adapters.files.loaded import LoadedRecording
from mossar_stream import KeyFrame, Segmentation, Skeleton, segment_recording
from mossar_tools.excerpt import excerpt
from mossar_tools.loaded_recording import load_recording
from mossar_tools.marks import Mark, Stretch
from mossar_tools.palette import LIGHT
from mossar_tools.poses import draw_poses
from mossar_tools.thinning import extremes, runs, strongest_apart

Figure = pytest.importorskip("matplotlib.figure").Figure


@pytest.fixture
def picture(mossar, tmp_path):
    """Draw a picture and return its texts by place, its shapes by colour, and its size."""

    def draw(*arguments):
        path = tmp_path / "picture.svg"
        status, _, err = mossar("segment", *arguments, "--plot", path)
        assert status == 0, err
        return Picture(ET.parse(path).getroot())

    return draw


class Picture:
    def __init__(self, root):
        self.width, self.height = (float(root.get(name).removesuffix("pt")) for name in ("width", "height"))
        self.texts = [
            "".join(element.itertext()) for element in root.iter("{http://www.w3.org/2000/svg}text")
        ]
        self.shapes = [
            (element.get("style") or "", element.get("d"))
            for element in root.iter("{http://www.w3.org/2000/svg}path")
        ]

    def bars(self, colour):
        """Return left, right and height of the filled rectangles of a colour, points."""
        found = []
        for style, d in self.shapes:
            if f"fill: {colour}" in style and "stroke" not in style:
                numbers = np.array(re.findall(r"-?\d+\.?\d*", d), float).reshape(-1, 2)
                (left, top), (right, bottom) = numbers.min(axis=0), numbers.max(axis=0)
                found.append((left, right, bottom - top))
        return found


def test_a_short_recording_is_drawn_whole_and_nothing_is_said_to_be_missing(picture):
    found = picture("demo:?seed=3&seconds=8", "--keep", "2")
    assert any("the 2 strongest of" in text for text in found.texts)
    assert not any("poses" in text for text in found.texts)


def test_a_long_recording_says_what_is_left_out_and_its_segments_are_seen(picture):
    found = picture("demo:?seed=3&seconds=600", "--level", "posture")
    said = " ".join(found.texts)
    poses = re.search(r"(\d+) of (\d+) poses", said)
    assert int(poses[1]) > 0.9 * int(poses[2])
    assert re.search(r"\d+ of \d+ joins of the tree", said)
    assert re.search(r"\d+ of \d+ marks of kept key frames", said)
    # The bars were covered by their own edges; now colour fills nearly all of the strip.
    tall = [bar for bar in found.bars(LIGHT.moving) + found.bars(LIGHT.resting) if bar[2] > 8 and bar[0] > 52]
    assert sum(right - left for left, right, _ in tall) > 0.8 * (found.width - 94)


def test_a_part_of_a_recording_is_drawn_in_the_width_asked_for(picture):
    found = picture("demo:?seed=3&seconds=60", "--from", "20", "--until", "30", "--width", "16")
    assert found.width == pytest.approx(16 * 72)
    assert {"20", "22", "28", "30"} <= set(found.texts)  # ticks of time; those of strength are powers of two
    assert not {"12", "14", "18", "40", "42"} & set(found.texts)
    assert any("from 20 to 30 s" in text for text in found.texts)


def test_the_former_name_of_until_works_with_a_warning(mossar, tmp_path):
    part = ("segment", "demo:?seconds=10", "--plot", tmp_path / "p.svg", "--force", "--from", "2")
    status, _, err = mossar(*part, "--to", "8")
    assert status == 0
    assert "--to is called --until now" in err
    assert "former name" in mossar(*part, "--to", "8", "--until", "9")[2]
    assert "--until now" not in mossar(*part, "--until", "8")[2]


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("--plot", "p.svg", "--from", "90"), "lasts"),
        (("--plot", "p.svg", "--from", "5", "--until", "4"), "lasts"),
        (("--plot", "p.svg", "--width", "2"), "inches"),
        (("--width", "9"), "--plot"),
        (("--json", "--from", "90"), "lasts"),
    ],
)
def test_an_impossible_part_is_wrong_usage(mossar, tmp_path, monkeypatch, arguments, word):
    monkeypatch.chdir(tmp_path)
    status, _, err = mossar("segment", "demo:?seconds=6", *arguments)
    assert (status, err.count("\n")) == (2, 1)
    assert word in err


def test_sinks_of_a_configuration_are_no_end_of_a_picture(mossar, tmp_path):
    config = tmp_path / "common.toml"
    config.write_text('to = ["osc://127.0.0.1:9000"]\n')
    status, _, err = mossar("segment", "demo:?seconds=6", "--config", config, "--json")
    assert status == 0, err


def test_figures_stay_within_their_panel_however_high_a_club_is_raised():
    times = np.arange(360) / 60
    positions = np.zeros((360, 6, 3), np.float32)
    positions[:, :, 1] = [0.9, 1.7, 1.2, 1.2, 0.0, 0.0]
    positions[:, :, 0] = [0, 0, 0.4, -0.4, 0.1, -0.1]
    angle = np.pi * np.clip(np.sin(times), 0, 1)
    positions[:, 2, 0] += 1.5 * np.sin(angle)
    positions[:, 2, 1] += 1.5 - 1.5 * np.cos(angle)  # up to 4.2 m
    skeleton = Skeleton(("hips", "head", "lhand", "rhand", "lfoot", "rfoot"), (-1, 0, 0, 0, 0, 0))
    whole = LoadedRecording("club", skeleton, 60.0, positions, times)
    result = segment_recording(positions, 60, skeleton, curves=True)
    keys = [KeyFrame(frame, frame / 60, "minimum", 0.5, 1.0) for frame in (10, 94, 200)]
    shown = excerpt(whole, result, Segmentation(keys, []))
    axes = Figure().add_subplot()
    axes.set_xlim(shown.start, shown.end)
    draw_poses(axes, whole, shown, (9.7, 1.55), LIGHT)
    heights = np.concatenate([line.get_ydata() for line in axes.lines])
    assert 0.95 < heights.max() <= 1.0


def test_all_true_cuts_of_a_long_performance_are_known():
    whole = load_recording("demo:?seed=3&seconds=2600&fps=10")
    assert len(whole.cuts) > 1000
    assert whole.cuts[0].time < 10
    assert whole.cuts[-1].time > 2580
    assert all(a.time < b.time for a, b in itertools.pairwise(whole.cuts))


def test_the_strongest_that_lie_apart_are_kept():
    rng = np.random.default_rng(5)
    keys = [
        Mark("", time, i, "minimum", 0.1, strength, kept=True)
        for i, (time, strength) in enumerate(
            zip(np.sort(rng.uniform(0, 100, 400)), rng.uniform(0, 9, 400), strict=True)
        )
    ]
    kept = strongest_apart(keys, 1.0)
    assert all(b.time - a.time >= 1.0 for a, b in itertools.pairwise(kept))
    assert max(keys, key=lambda key: key.strength) in kept
    for key in keys:  # each one left out gave way to a stronger one nearby
        near = [other for other in kept if abs(other.time - key.time) < 1.0]
        assert key in kept or max(other.strength for other in near) > key.strength
    assert strongest_apart(keys[:1], 1.0, taken=[keys[0].time + 0.5]) == []


def test_a_thinned_curve_keeps_its_peaks():
    times = np.arange(10_000) / 60
    values = np.sin(times)
    values[[17, 7777]] = 5.0, -5.0
    values[100] = np.nan
    rough, low, high = extremes(times, values, 300)
    assert len(rough) == len(low) == len(high) == 300
    assert (low.min(), high.max()) == (-5.0, 5.0)
    np.testing.assert_array_equal(
        extremes(times[:50], values[:50], 300), [times[:50], values[:50], values[:50]]
    )


def test_segments_too_narrow_to_be_seen_become_what_most_of_the_time_is():
    edges = np.arange(4001) / 10
    states = ["moving" if i % 4 else "resting" for i in range(2000)] + ["resting"] * 2000
    given = [Stretch(a, b, state) for (a, b), state in zip(itertools.pairwise(edges), states, strict=True)]
    parts = runs(given, 100)
    assert len(parts) < 400
    assert parts[0].start == 0
    assert parts[-1].end == 400
    moving = sum(part.end - part.start for part in parts if part.state == "moving")
    assert moving == pytest.approx(200, abs=3)
    assert runs(given[:3], 100) == given[:3]
