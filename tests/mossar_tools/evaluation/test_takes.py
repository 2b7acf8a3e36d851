import json

import numpy as np
import pytest

from mossar_stream import MossarError, SettingsError
from mossar_tools.evaluation.labels import LabelError
from mossar_tools.evaluation.performer import demo_takes
from mossar_tools.evaluation.takes import load_folder


def test_a_take_has_its_recording_and_its_cuts_in_seconds(relabel):
    (take,) = load_folder(relabel(cuts=[30, [60, 66, 75]]))
    assert (take.name, take.level, take.fps) == ("walk", "motion", 30.0)
    assert take.positions.shape == (len(take.times), len(take.skeleton), 3)
    assert [(cut.earliest, cut.middle, cut.latest) for cut in take.cuts] == [(1, 1, 1), (2, 2.2, 2.5)]


def test_cuts_in_seconds_are_those_in_frames(relabel):
    (frames,) = load_folder(relabel(cuts=[30, [60, 66, 75]]))
    (seconds,) = load_folder(relabel(cuts=[1, [2, 2.2, 2.5]], cuts_in="seconds"))
    assert seconds.cuts == frames.cuts
    (judged,) = load_folder(relabel(judges=[[1, 2], [1.1, 2.1]], cuts_in="seconds"))
    assert [cut.middle for cut in judged.cuts] == pytest.approx([1.05, 2.05], abs=0.01)


@pytest.mark.parametrize("name", ["cuts", "judges"])
@pytest.mark.parametrize(("seconds", "said"), [([1.2, 3.4], "1.2 is no frame"), ([1, 3, 4], "first 4 of")])
def test_seconds_are_not_taken_for_frames_in_silence(relabel, name, seconds, said):
    moments = [seconds] if name == "judges" else seconds
    with pytest.raises(LabelError, match=rf'walk\.json: .*{said}.*"cuts_in": "seconds"'):
        load_folder(relabel(**{name: moments}))
    (take,) = load_folder(relabel(**{name: moments}, cuts_in="frames"))
    assert take.cuts[0].middle < 0.1


def test_seconds_beyond_the_recording_are_refused(relabel):
    with pytest.raises(LabelError, match=r"999 s is not in the recording, which lasts \d"):
        load_folder(relabel(cuts=[999], cuts_in="seconds"))


def test_judges_become_cuts(relabel):
    (take,) = load_folder(relabel(judges=[[30, 60], [31, 61], [29, 100]]))
    assert [cut.middle for cut in take.cuts] == pytest.approx([1.0, 60.5 / 30, 100 / 30], abs=0.01)


def test_labels_in_folders_are_found_and_named_by_their_path(labelled, tmp_path_factory):
    top = tmp_path_factory.mktemp("top")
    labelled.rename(top / "first")
    assert [take.name for take in load_folder(top)] == ["first/walk"]


def test_joints_without_confidence_are_missing(tmp_path):
    frames = [
        {
            "type": "meta",
            "performer": "p1",
            "names": ["hip", "hand"],
            "parents": [-1, 0],
            "root": 0,
            "fps": 30,
        },
        *(
            {
                "type": "frame",
                "performer": "p1",
                "seq": i,
                "t": i / 30,
                "xyz": [[0, 0, 0], [1, 0, 0]],
                "conf": [1, i % 2],
            }
            for i in range(4)
        ),
    ]
    (tmp_path / "walk.jsonl").write_text("\n".join(json.dumps(frame) for frame in frames))
    (tmp_path / "walk.json").write_text('{"recording": "walk.jsonl", "cuts": [2], "unit": "m"}')
    (take,) = load_folder(tmp_path)
    assert np.isnan(take.positions[:, 1, 0]).tolist() == [True, False, True, False]


def test_a_label_without_its_recording_says_what_is_missing(relabel):
    with pytest.raises(LabelError, match=r"walk\.json: it names run\.npz, which is not in"):
        load_folder(relabel(recording="run.npz", cuts=[1]))


def test_a_label_without_its_skeleton_says_what_is_missing(relabel):
    with pytest.raises(LabelError, match=r"it names 86\.asf"):
        load_folder(relabel(skeleton="86.asf", cuts=[1]))


def test_a_cut_beyond_the_recording_is_refused(relabel):
    with pytest.raises(LabelError, match="frame 100000 is not in the recording"):
        load_folder(relabel(cuts=[100000]))


def test_a_recording_that_cannot_be_read_is_named(labelled):
    (labelled / "walk.npz").write_bytes(b"no archive")
    with pytest.raises(MossarError, match=r"walk\.npz"):
        load_folder(labelled)


def test_the_built_in_performer_is_shown_with_and_without_noise():
    takes = list(demo_takes(seeds=2))
    assert [take.name for take in takes] == [
        "demo, no noise 1",
        "demo, no noise 2",
        "demo, Kinect noise 1",
        "demo, Kinect noise 2",
    ]
    assert all(take.cuts and take.level == "motion" for take in takes)


def test_options_of_the_performer_are_its_own_kind():
    (take,) = demo_takes("demo:?fps=30&seconds=4&noise=0.01", seeds=1)
    assert (take.fps, len(take.times), take.group) == (30.0, 120, "demo:?fps=30&seconds=4&noise=0.01")


@pytest.mark.parametrize("url", ["demo:?fps=fast", "demo:?colour=red", "demo:?fps=0", "demo:?seconds=0.001"])
def test_impossible_options_of_the_performer_are_refused_in_one_line(url):
    with pytest.raises(SettingsError, match=r"demo|fps"):
        list(demo_takes(url, seeds=1))
