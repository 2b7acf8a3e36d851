import pytest

from mossar_tools.console import LOGGER
from mossar_tools.evaluation.labels import LabelError, read_folder


def test_a_label_file_is_read_and_other_keys_are_passed_over(relabel):
    folder = relabel(cuts=[10, [20, 22, 25]], source="drawn by hand")
    ((path, labels),) = read_folder(folder)
    assert path.name == "walk.json"
    assert labels.cuts == [10.0, (20.0, 22.0, 25.0)]


def test_json_that_is_no_label_is_passed_over(labelled):
    (labelled / "pose.json").write_text('[{"people": []}]')
    (labelled / "notes.json").write_text('{"cuts": []}')
    assert len(read_folder(labelled)) == 1


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"cuts": [1], "judges": [[1]]}, "either cuts or judges"),
        ({"cuts": [[1, 2]]}, "cuts"),
        ({"cuts": ["1"]}, "cuts"),
        ({"cuts": [[5, 4, 6]]}, "cut 1 must be"),
        ({"cuts": [20, 10]}, "cut 2 begins"),
        ({"cuts": [-1]}, "before frame 0"),
        ({"cuts": [10], "level": "dance"}, "level"),
        ({"cuts": [10], "cuts_in": "hours"}, "cuts_in"),
        ({"cuts": [10], "fps": 0}, "fps"),
        ({"cuts": [10], "tolerance_s": -1}, "tolerance_s"),
        ({"judges": [[10]], "bandwidth_s": 0}, "bandwidth_s"),
        ({"cuts": [10], "recording": 7}, "recording"),
    ],
)
def test_a_label_file_that_nobody_can_mean_is_refused_in_one_line(relabel, fields, problem):
    folder = relabel(**fields)
    with pytest.raises(LabelError, match=problem) as error:
        read_folder(folder)
    assert "walk.json" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("foreign", "said"),
    [
        ('{"recording": ', "no valid JSON"),
        ("", "no valid JSON"),
        ("[" * 100_000, "no valid JSON"),
        ('{"recording": "walk.npz", "fps": 30, "key_frames": [], "segments": []}', "neither cuts nor judges"),
    ],
)
def test_foreign_json_is_told_of_in_a_line_and_ends_nothing(labelled, caplog, monkeypatch, foreign, said):
    monkeypatch.setattr(LOGGER, "handlers", [caplog.handler])
    monkeypatch.setattr(LOGGER, "propagate", False)
    (labelled / "below").mkdir()
    (labelled / "below" / "foreign.json").write_text(foreign)
    assert [path.name for path, _ in read_folder(labelled)] == ["walk.json"]
    (record,) = caplog.records
    assert "foreign.json is skipped: " in record.getMessage()
    assert said in record.getMessage()
    assert "\n" not in record.getMessage()


def test_a_folder_without_labels_says_what_to_put_there(tmp_path):
    with pytest.raises(LabelError, match=r"no label file; put NAME\.json"):
        read_folder(tmp_path)


def test_a_folder_that_is_not_there_or_is_a_file_is_refused(labelled):
    with pytest.raises(LabelError, match="there is no such folder"):
        read_folder(labelled / "nowhere")
    with pytest.raises(LabelError, match="this is a file"):
        read_folder(labelled / "walk.npz")
