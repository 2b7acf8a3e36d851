"""Agreement of labels: exact on cases that can be reckoned by hand, and the same whichever format labels come in."""

import csv
import json

import pytest

from mossar_adapters.annotations.tiers import Mark, Tier
from mossar_adapters.annotations.writing import write_annotations
from mossar_tools.agreement.measures import agreement, pooled


def stretches(*marks):
    return Tier("moves", tuple(Mark(*mark) for mark in marks))


ANN = stretches((0.0, 1.0, "a"), (1.0, 2.0, "b"), (3.0, 4.0, "a"))
BO = stretches((0.0, 1.2, "a"), (1.2, 2.0, "b"), (3.0, 4.0, "b"))


def test_a_labeller_agrees_with_itself_in_everything():
    same = agreement(ANN, ANN)
    assert (same.kappa, set(same.offsets)) == (1.0, {0.0})
    assert [same.f1(tolerance) for tolerance in same.hits] == [1.0] * 4


def test_what_can_be_reckoned_by_hand():
    found = agreement(ANN, BO, (0.1, 0.25))
    # Boundaries 0 1 2 3 4 and 0 1.2 2 3 4.
    assert (found.boundaries, found.hits) == ((5, 5), {0.1: 4, 0.25: 5})
    assert found.f1(0.1) == pytest.approx(0.8)
    assert sorted(found.offsets) == pytest.approx([0, 0, 0, 0, 0.2])
    expected = {("a", "a"): 1.0, ("b", "a"): 0.2, ("b", "b"): 0.8, ("", ""): 1.0, ("a", "b"): 1.0}
    assert found.confusion == pytest.approx(expected)
    # Of 4 s they agree in 2.8; by chance in (2 * 1.2 + 1 * 1.8 + 1 * 1) / 16.
    chance = (2 * 1.2 + 1.8 + 1) / 16
    assert found.kappa == pytest.approx((0.7 - chance) / (1 - chance))


def test_kappa_is_that_of_samples():
    metrics = pytest.importorskip("sklearn.metrics")

    def at(tier, time):
        return next((mark.label for mark in tier.marks if mark.start <= time < mark.end), "")

    times = [0.005 + 0.01 * k for k in range(400)]
    sampled = metrics.cohen_kappa_score([at(ANN, t) for t in times], [at(BO, t) for t in times])
    assert agreement(ANN, BO).kappa == pytest.approx(sampled, abs=1e-9)


def test_moments_have_no_kappa_and_their_names_are_counted():
    one = Tier("steps", (Mark(1, 1, "left"), Mark(2, 2, "right"), Mark(9, 9, "left")), moments=True)
    other = Tier("steps", (Mark(1.1, 1.1, "left"), Mark(2, 2, "left")), moments=True)
    found = agreement(one, other)
    assert found.kappa is None
    assert found.confusion == {("left", "left"): 1, ("right", "left"): 1, ("left", ""): 1}


def test_every_second_counts_the_same_in_what_is_pooled():
    short, long = agreement(ANN, BO), agreement(stretches((0, 40, "a")), stretches((0, 40, "a")))
    whole = pooled([short, long])
    assert whole.confusion["a", "a"] == pytest.approx(41)
    assert whole.boundaries == (7, 7)


def test_one_name_all_the_time_has_no_kappa():
    assert agreement(stretches((0, 4, "a")), stretches((0, 4, "a"))).kappa is None


@pytest.mark.parametrize("suffix", [".eaf", ".TextGrid", ".vtt", ".tsv"])
def test_labels_of_any_two_formats_are_compared(mossar, tmp_path, suffix):
    if suffix in {".eaf", ".TextGrid"}:
        pytest.importorskip("pympi")
    write_annotations(tmp_path / "ann.txt", [ANN], 4.0)
    write_annotations(tmp_path / f"bo{suffix}", [BO], 4.0)
    status, out, err = mossar("agree", tmp_path / "ann.txt", tmp_path / f"bo{suffix}", "--json")
    assert (status, err) == (0, "")
    (pair,) = json.loads(out)["pairs"]
    assert (pair["a"], pair["b"]) == ("ann.txt", f"bo{suffix}")
    assert pair["all"]["kappa"] == pytest.approx(agreement(ANN, BO).kappa)
    assert pair["all"]["f1_0.1"] == pytest.approx(0.8)


def test_folders_are_compared_by_file_and_pooled_and_drawn(mossar, tmp_path):
    for folder, tier in (("ann", ANN), ("bo", BO), ("cy", BO)):
        (tmp_path / folder).mkdir()
        for name in ("take1.txt", "take2.vtt"):
            write_annotations(tmp_path / folder / name, [tier], 4.0)
    (tmp_path / "bo" / "other.txt").write_text("1\t2\tmoves: a\n")
    table, picture = tmp_path / "table.csv", tmp_path / "picture.svg"
    folders = [tmp_path / name for name in ("ann", "bo", "cy")]
    status, out, err = mossar("agree", *folders, "--csv", table, "--plot", picture)
    assert status == 0
    assert "other.txt: skipped" in err
    rows = list(csv.DictReader(table.read_text().splitlines()))
    assert [(row["a"], row["b"], row["recording"]) for row in rows[:3]] == [
        ("ann", "bo", "take1"),
        ("ann", "bo", "take2"),
        ("ann", "bo", "all"),
    ]
    assert len(rows) == 9
    assert float(rows[-1]["kappa"]) == 1.0
    assert "ann has a where bo has b: 2 s" in out
    assert picture.read_text().startswith("<?xml")


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["a.txt"], "two or more"),
        (["a.txt", "nowhere.eaf"], "no such file"),
        (["a.txt", "folder"], "files with files"),
        (["a.txt", "b.txt", "--tier", "yours"], "no tier called yours; there are: moves"),
        (["a.txt", "b.txt", "--tier", "a,b,c"], "one for each of the 2"),
        (["a.txt", "two.txt"], "which tiers"),
        (["a.txt", "moments.txt", "--tier", "moves,steps"], "moments are compared with moments"),
        (["a.txt", "b.docx"], "annotations are read from"),
        (["a.txt", "b.txt", "--tolerance", "0"], "not a positive number"),
        (["folder", "empty"], "no recording is labelled in all"),
    ],
)
def test_wrong_usage_is_one_line_and_status_2(mossar, tmp_path, monkeypatch, arguments, problem):
    monkeypatch.chdir(tmp_path)
    for name in ("a.txt", "b.txt"):
        write_annotations(tmp_path / name, [ANN], 4.0)
    mine = [Tier("mine", ANN.marks), Tier("yours", ANN.marks)]
    write_annotations(tmp_path / "two.txt", mine, 4.0)
    write_annotations(tmp_path / "moments.txt", [Tier("steps", (Mark(1, 1, "x"),), moments=True)], 4.0)
    (tmp_path / "b.docx").write_text("")
    for name in ("folder", "empty"):
        (tmp_path / name).mkdir()
    write_annotations(tmp_path / "folder" / "a.txt", [ANN], 4.0)
    status, _, err = mossar("agree", *arguments)
    assert status == 2
    assert problem in err
    assert "Traceback" not in err
