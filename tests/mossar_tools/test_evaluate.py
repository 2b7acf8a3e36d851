import json
from pathlib import Path

import pytest

from checks.fuzz.recordings import c3d
from mossar_adapters.annotations.tiers import Mark, Tier
from mossar_adapters.annotations.writing import write_annotations
from mossar_adapters.files.c3d_events import C3dEvent, write_events
from mossar_stream import Settings
from mossar_tools.cli import main
from mossar_tools.evaluation.metrics import mean_scores, median
from mossar_tools.evaluation.mossar import mossar_methods, stream
from mossar_tools.evaluation.takes import load_folder

LABELLED = Path(__file__).parents[3] / "shared" / "data" / "labelled"


@pytest.fixture(scope="module")
def takes():
    if not LABELLED.is_dir():
        pytest.skip("no labelled recordings in ../shared/data/labelled")
    return load_folder(LABELLED)


MOTION = ("precog",)  # where nothing else is said; the four CMU takes for clusters


def reached(takes, level, status, **settings):
    folders = MOTION if level == "motion" else ("",)
    own = [take for take in takes if take.level == level and take.name.rpartition("/")[0] in folders]
    return mean_scores([stream(take, Settings(**settings), status).scores(take) for take in own])


def test_final_key_frames_of_clusters_are_accurate_and_in_time(takes):
    scores = reached(takes, "cluster", "final")
    assert scores.f1 >= 0.85
    assert median(scores.delays) <= 5.0


def test_final_key_frames_of_clusters_hold_with_four_angles(takes):
    own = [take for take in takes if take.name.startswith("cmu86_angles/")]
    scores = mean_scores([stream(take, Settings(), "final").scores(take) for take in own])
    assert scores.f1 >= 0.75
    assert median(scores.delays) <= 4.5


def test_final_key_frames_of_motions_are_accurate_and_in_time(takes):
    scores = reached(takes, "motion", "final")
    assert scores.f1 >= 0.75
    assert median(scores.delays) <= 3.5


@pytest.mark.parametrize(
    ("folder", "least"),
    [("precog", 0.755), ("vmci", 0.865), ("gesture_phase", 0.625), ("ui_prmd", 0.765)],
)
def test_one_bundle_serves_all_sets(takes, folder, least):
    own = [take for take in takes if take.name.startswith(f"{folder}/")]
    scores = mean_scores([stream(take, Settings(), "final").scores(take) for take in own])
    assert scores.f1 >= least
    assert median(scores.delays) <= 1.8


def test_confirmed_key_frames_of_clusters_miss_little_and_are_early(takes):
    scores = reached(takes, "cluster", "confirmed")
    assert scores.recall >= 0.95
    assert scores.key_frames <= 15
    assert median(scores.delays) <= 0.5


@pytest.mark.parametrize("level", ["motion", "cluster"])
def test_a_bounded_window_costs_hardly_any_accuracy(takes, level):
    bounded, unbounded = reached(takes, level, "final"), reached(takes, level, "final", remerge_window=1024)
    assert abs(bounded.f1 - unbounded.f1) <= 0.02


def test_the_built_in_performer_is_evaluated_without_any_data(capsys, tmp_path):
    picture = tmp_path / "strips.svg"
    assert main(["evaluate", "demo:", "--seeds", "1", "--json", "--plot", str(picture)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [group["group"] for group in found["groups"]] == ["demo, no noise", "demo, Kinect noise"]
    names = {method["method"] for method in found["groups"][0]["methods"]}
    assert {method.name for method in mossar_methods(Settings())} < names
    assert {"a cut every k seconds", "random cuts (knows the number of cuts)"} < names
    for method in found["groups"][0]["methods"]:
        assert 0 <= method["mean"]["f1"] <= 1
    assert picture.stat().st_size > 10_000


def test_a_labelled_folder_gives_a_table_for_people(capsys, tmp_path):
    (tmp_path / "walk.csv").write_text(table())
    (tmp_path / "walk.json").write_text('{"recording": "walk.csv", "fps": 30, "unit": "m", "cuts": [30, 60]}')
    assert main(["evaluate", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "motion: 1 recordings, 3 s, 2 true cuts" in out
    assert "Mossar default, streaming" in out


def labelled_sets(tmp_path):
    for name in ("one", "two"):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "walk.csv").write_text(table())
        label = '{"recording": "walk.csv", "fps": 30, "unit": "m", "cuts": [30, 60]}'
        (folder / "walk.json").write_text(label)
    return [str(tmp_path / "one"), str(tmp_path / "two")]


def test_a_stray_pair_of_a_table_and_a_text_is_passed_over(capsys, tmp_path):
    folder = Path(labelled_sets(tmp_path)[0])
    (folder / "notes.csv").write_text("who,what\nann,late\n")
    (folder / "notes.txt").write_text("ann came late\n")
    assert main(["evaluate", str(folder), "--json"]) == 0
    told = capsys.readouterr()
    assert "notes.txt and notes.csv are skipped" in told.err
    assert len(json.loads(told.out)["groups"][0]["recordings"]) == 1


def test_a_folder_of_nothing_else_is_refused_with_the_reason(capsys, tmp_path):
    (tmp_path / "notes.csv").write_text("who,what\nann,late\n")
    (tmp_path / "notes.txt").write_text("ann came late\n")
    assert main(["evaluate", str(tmp_path)]) == 2
    assert "notes.txt" in capsys.readouterr().err


def test_several_sets_stand_beside_each_other_and_one_can_be_left_out(capsys, tmp_path):
    folders = labelled_sets(tmp_path)
    assert main(["evaluate", *folders, "--leave-out", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [group["group"] for group in found["groups"]] == ["one", "two"]
    methods = {method["method"]: method for method in found["groups"][0]["methods"]}
    assert list(methods)[:3] == ["final", "final, strength chosen on the other sets", "confirmed"]
    assert float(methods["final, strength chosen on the other sets"]["recordings"][0]["variant"]) > 0
    assert "a cut every k seconds" in methods


def test_sets_can_be_stretched_in_time(capsys, tmp_path):
    folders = labelled_sets(tmp_path)
    assert main(["evaluate", *folders, "--stretch", "0.6,1,2", "--json"]) == 0
    groups = json.loads(capsys.readouterr().out)["groups"]
    names = [f"{name} x{factor}" for name in ("one", "two") for factor in ("0.6", "1", "2")]
    assert [group["group"] for group in groups] == names
    lasted = [group["recordings"][0]["duration_s"] for group in groups]
    assert lasted[2] == pytest.approx(2 * lasted[1], abs=0.1)
    assert main(["evaluate", folders[0], "--stretch", "2"]) == 0
    assert "x2" in capsys.readouterr().out.splitlines()[0]


@pytest.mark.parametrize("other", [["--leave-out"], ["--plot", "strips.png"], ["--strict", "0.3"]])
def test_stretching_goes_with_no_other_way_to_score(capsys, tmp_path, other):
    assert main(["evaluate", *labelled_sets(tmp_path), "--stretch", "2", *other]) == 2
    assert f"--stretch and {other[0]}" in capsys.readouterr().err


@pytest.mark.parametrize("factors", ["0", "11", "x"])
def test_a_factor_that_is_none_is_refused(capsys, tmp_path, factors):
    assert main(["evaluate", labelled_sets(tmp_path)[0], "--stretch", factors]) == 2
    assert "--stretch" in capsys.readouterr().err


def test_leaving_out_needs_several_sets(capsys, tmp_path):
    assert main(["evaluate", labelled_sets(tmp_path)[0], "--leave-out"]) == 2
    assert "needs several folders" in capsys.readouterr().err


def test_tune_finds_the_strength_for_a_number_a_minute_and_saves_it(capsys, tmp_path):
    saved = tmp_path / "settings.toml"
    assert main(["tune", "demo:?seed=3", "--per-minute", "20", "--save", str(saved)]) == 0
    out = capsys.readouterr().out
    assert "strength" in out
    assert "a minute" in out.splitlines()[-1]
    assert main(["segment", "demo:?seed=3", "--config", str(saved), "--json"]) == 0
    segments = json.loads(capsys.readouterr().out)["segments"]
    minutes = (segments[-1]["end_time"] - segments[0]["start_time"]) / 60
    assert (len(segments) - 1) / minutes == pytest.approx(20, abs=3)


def test_what_tune_saves_means_the_same_with_the_bundle_of_another_level(capsys, tmp_path):
    saved = tmp_path / "settings.toml"
    arguments = ["--level", "cluster", "--per-minute", "10", "--save", str(saved)]
    assert main(["tune", "demo:?seed=3", *arguments]) == 0
    count = int(capsys.readouterr().out.splitlines()[-1].split(": ")[1].split(" key frames")[0])
    assert main(["segment", "demo:?seed=3", "--config", str(saved), "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["segments"]) == count + 1


def test_tune_chooses_by_labels(capsys, tmp_path):
    folder = labelled_sets(tmp_path)[0]
    assert (
        main(["tune", f"{folder}/walk.csv", "--unit", "m", "--fps", "30", "--labels", f"{folder}/walk.json"])
        == 0
    )
    assert "for 2 cuts, F1" in capsys.readouterr().out


@pytest.mark.parametrize("suffix", [".eaf", ".TextGrid", ".txt", ".vtt", ".tsv"])
def test_tune_chooses_by_what_was_annotated(capsys, tmp_path, suffix):
    if suffix in {".eaf", ".TextGrid"}:
        pytest.importorskip("pympi")
    folder = labelled_sets(tmp_path)[0]
    marks = tuple(Mark(*pair, "part") for pair in ((0.0, 1.0), (1.0, 2.0), (2.0, 3.0)))
    write_annotations(tmp_path / f"walk{suffix}", [Tier("steps", marks), Tier("mine", marks[:1])], 3.0)
    usual = [
        "tune",
        f"{folder}/walk.csv",
        "--unit",
        "m",
        "--fps",
        "30",
        "--labels",
        f"{tmp_path}/walk{suffix}",
    ]
    assert main([*usual, "--tier", "steps"]) == 0
    assert "for 2 cuts, F1" in capsys.readouterr().out
    assert main(usual) == 2
    names = capsys.readouterr().err.strip().partition("there are: ")[2]  # Audacity's in the order of time
    assert sorted(names.split(", ")) == ["mine", "steps"]


def test_tune_and_evaluate_take_tables_and_events_of_c3d_files(capsys, tmp_path):
    labels, take = tmp_path / "labels.csv", tmp_path / "take.c3d"
    labels.write_text("start,end,name\n0.1,0.4,up\n")
    (tmp_path / "plain.c3d").write_bytes(c3d(60))
    assert main(["tune", str(tmp_path / "plain.c3d"), "--labels", str(labels)]) == 0
    assert "for 2 cuts, F1" in capsys.readouterr().out
    write_events(tmp_path / "plain.c3d", take, [C3dEvent("Key Frame", 0.25), C3dEvent("Key Frame", 0.5)])
    (tmp_path / "plain.c3d").unlink()
    assert main(["tune", str(take), "--labels", str(take)]) == 0
    assert "for 2 cuts, F1" in capsys.readouterr().out
    assert main(["evaluate", str(tmp_path), "--json"]) == 0
    assert "take" in capsys.readouterr().out


def table():
    rows = ["hip_x,hip_y,hip_z,hand_x,hand_y,hand_z"]
    rows += [f"0,1,0,{min(max(i - 30, 0), 30) / 30},1,0.5" for i in range(90)]
    return "\n".join(rows) + "\n"


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["nowhere"], "there is no such folder"),
        (["osc://127.0.0.1:9000"], "takes a folder of labelled recordings or demo:"),
        (["demo:?colour=red"], "demo"),
        (["demo:", "--plot", "strips.gif"], "pictures are"),
        (["demo:", "--set", "colour=red"], "no setting called"),
        (["demo:", "--set", "level=cluster"], "the level is that of each recording's label"),
        (["demo:", "--level", "cluster"], "unrecognized arguments: --level"),
    ],
)
def test_wrong_usage_is_one_line_and_status_2(capsys, arguments, problem):
    assert main(["evaluate", *arguments]) == 2
    err = capsys.readouterr().err
    assert problem in err
    assert len(err.splitlines()) == 1
