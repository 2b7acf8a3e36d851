"""Every setting is explained, with the value that counts."""

import csv
import json

import pytest

from mossar_stream import SETTING_METAS, Settings


def test_every_setting_is_explained():
    assert set(SETTING_METAS) == set(Settings.__struct_fields__)
    assert all(meta.effect and meta.written for meta in SETTING_METAS.values())


@pytest.mark.parametrize("arguments", [[], ["--preset", "paper"], ["--level", "cluster"], ["--level", "0.3"]])
def test_values_are_those_that_count(mossar, arguments):
    status, out, _ = mossar("settings", "--json", *arguments)
    found = json.loads(out)["settings"]
    given = dict(zip(arguments[::2], arguments[1::2], strict=True))
    level = given.get("--level", "motion")
    expected = Settings.build(given.get("--preset", "default"), {"level": level}).resolved()
    assert status == 0
    assert found["window"]["value"] == expected.window
    assert found["remerge_seconds"]["value"] == expected.remerge_seconds
    assert found["features"]["value"]["log_speed"] == expected.features.log_speed


def test_where_a_value_comes_from_is_said(mossar):
    out = mossar(
        "settings", "--preset", "game", "--level", "cluster", "--set", "sig_threshold=0.03", "--csv"
    )[1]
    rows = {row["name"]: row for row in csv.DictReader(out.splitlines())}
    origins = {
        name: rows[name]["from"]
        for name in ("remerge_seconds", "refine", "sig_threshold", "level", "max_gap")
    }
    assert origins == {
        "remerge_seconds": "preset game",
        "refine": "level cluster",
        "sig_threshold": "you",
        "level": "you",
        "max_gap": "default",
    }
    assert rows["sig_threshold"]["value"] == "0.03"
    assert rows["features.log_speed"]["value"] == "0.75"
    assert rows["max_gap"]["legal"] == "0 to 60"
    for name in ("tempo", "repetitions", "phase"):
        assert rows[name]["legal"] == "true, false"
    assert rows["limbs"]["legal"].startswith("true, false or groups")


def test_what_options_of_their_own_set_comes_from_you(mossar):
    rows = {
        row["name"]: row
        for row in csv.DictReader(
            mossar("settings", "--limbs", "--repetitions", "--rests", "merge", "--csv")[1].splitlines()
        )
    }
    origins = [rows[name]["from"] for name in ("limbs", "repetitions", "rests", "phase")]
    assert origins == ["you", "you", "you", "default"]


@pytest.mark.parametrize(
    ("given", "name", "value", "origin"),
    [
        (["similarity=likelihood"], "refine", "0", "level motion"),
        (["window=0.2"], "range_floor", "0.02", "window=0.2"),
        (["window=0.2"], "rate_limit", "30", "level motion"),
        (["range=fixed", "range_max=2"], "rate_limit", "0", "range=fixed"),
        (["level=cluster", "similarity=path_kernel"], "location", "none", "similarity=path_kernel"),
        (["level=cluster"], "location", "free", "level cluster"),
        ([], "rests", "keep", "level motion"),
        (["level=posture"], "rests", "merge", "level posture"),
        (["similarity=likelihood"], "rests", "merge", "similarity=likelihood"),
        (["similarity=likelihood"], "tempo", "false", "similarity=likelihood"),
        (["remerge_seconds=0.5"], "tempo", "false", "remerge_seconds=0.5"),
    ],
)
def test_a_value_says_what_it_follows(mossar, given, name, value, origin):
    chosen = [part for one in given for part in ("--set", one)]
    out = mossar("settings", *chosen, "--csv")[1]
    rows = {row["name"]: row for row in csv.DictReader(out.splitlines())}
    assert (rows[name]["value"], rows[name]["from"]) == (value, origin)


def names_in(out):
    return [
        line.split()[0] for line in out.splitlines() if line.split()[:1] and line.split()[0] in SETTING_METAS
    ]


def test_a_table_of_five_comes_without_an_option_and_of_all_with_one(mossar):
    status, out, _ = mossar("settings")
    assert status == 0
    assert names_in(out) == ["level", "rests", "sig_threshold", "range_floor", "remerge_seconds"]
    rows = mossar("settings", "--csv")[1].splitlines()
    assert f"{len(rows) - 1 - 5} more: mossar settings --all" in out
    assert "window" in names_in(mossar("settings", "--set", "window=0.3")[1])
    assert {name.partition(".")[0] for name in names_in(mossar("settings", "--all")[1])} >= {
        name for name in SETTING_METAS if name not in {"features", "variance_floor"}
    }


@pytest.mark.parametrize("columns", [46, 80])
def test_the_table_fits_the_terminal(mossar, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    assert max(map(len, mossar("settings", "--all")[1].splitlines())) <= columns
