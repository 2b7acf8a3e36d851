"""Rules, warnings and explanations on the command line: teach --strict --again --mirrored --facing, run --explain."""

import json
from pathlib import Path

import pytest

PUNCH = "demo:?tempo=0.6&moves=rest:1,punch_left"
KICK = "demo:?tempo=0.6&moves=rest:1,kick_right"


@pytest.fixture
def shown(run, tmp_path):
    path = str(tmp_path / "shown.json")
    for source, name, begin, until in ((PUNCH, "punch", "1.45", "2.18"), (KICK, "kick", "1.47", "2.4")):
        assert run("teach", path, source, "--name", name, "--from", begin, "--until", until).status == 0
    return path


def content(path):
    return json.loads(Path(path).read_text())


def test_rules_are_set_alone_and_listed(run, shown):
    ran = run("teach", shown, "--name", "punch", "--strict", "0.8", "--again", "0.5", "--mirrored")
    assert (ran.status, ran.err.strip()) == (0, "punch: strict 0.8, again after 0.5 s, mirrored")
    assert run("teach", shown, "--facing", "as_shown").status == 0
    assert content(shown)["rules"] == {"punch": {"strict": 0.8, "again": 0.5, "mirrored": True}}
    listed = run("teach", shown, "--list").out
    assert "; strict 0.8, again after 0.5 s, mirrored" in listed
    assert "facing as_shown" in listed
    assert (
        run("teach", shown, "--name", "punch", "--no-mirrored", "--strict", "0.5", "--again", "0").status == 0
    )
    assert content(shown)["rules"] == {}


def test_rules_are_set_while_showing(run, shown):
    ran = run("teach", shown, KICK, "--name", "kick", "--from", "1.47", "--until", "2.4", "--again", "2")
    assert ran.status == 0
    assert content(shown)["rules"] == {"kick": {"again": 2.0}}


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (["--strict", "0.8"], "--name says of which"),
        (["--name", "punch", "--strict", "2"], "strict is a number from 0 to 1"),
        (["--name", "punch", "--again", "-1"], "again is a number from 0"),
        (["--name", "jump", "--strict", "0.8"], "no move called 'jump'"),
        (["--facing", "left"], "invalid choice"),
    ],
)
def test_rules_that_make_no_sense_are_refused(run, shown, given, says):
    before = content(shown)
    ran = run("teach", shown, *given)
    assert ran.status == 2
    assert says in ran.err
    assert content(shown) == before


def test_an_example_that_is_unlike_the_others_is_warned_of(run, shown):
    ran = run("teach", shown, PUNCH, "--name", "punch", "--from", "1.45", "--until", "1.75")
    assert ran.status == 0
    assert "punch: example 2 takes 0.30 s, the others 0.72 s; was the whole move shown?" in ran.err
    ran = run("teach", shown, KICK, "--name", "punch", "--from", "1.47", "--until", "2.4")
    assert "is another movement than the others" in ran.err
    assert "it is nearer to kick" in ran.err
    assert "was the whole move shown?" in run("teach", shown, "--list").err


def test_run_explains_each_movement_and_changes_no_event(run, shown):
    source = "demo:?seed=4&tempo=0.6&moves=rest:1,punch_left,rest:1,kick_right,rest:1,squat,rest:1"
    given = [
        "run",
        source,
        "--moves",
        shown,
        "--emit",
        "move",
        "--seconds",
        "20",
        "--speed",
        "max",
        "--run-id",
        "x",
    ]
    plain, explained = run(*given), run(*given, "--explain")
    assert (plain.status, explained.status) == (0, 0)
    assert plain.out == explained.out
    lines = [line for line in explained.err.splitlines() if "mossar: p1, " in line]
    assert any("punch recognised at a cost of" in line for line in lines)
    assert any("not recognised at a cost of" in line and "the cost is too high" in line for line in lines)
    assert not [line for line in plain.err.splitlines() if "mossar: p1, " in line]
    assert "--explain needs --moves" in run("run", "demo:", "--explain").err


def test_the_mirror_image_is_followed_under_the_other_name(run, events, tmp_path):
    path = str(tmp_path / "kicks.json")
    assert run("teach", path, KICK, "--name", "kick_right", "--from", "1.2", "--until", "2.6").status == 0
    left = "demo:?tempo=0.6&moves=rest:1,kick_left,rest:1"
    asked = ("run", left, "--speed", "max", "--moves", path, "--emit", "follow.done", "--follow")
    ran = run(*asked, "kick_left")
    assert (ran.status, "no such move; there are kick_right" in ran.err) == (2, True)
    assert run("teach", path, "--name", "kick_right", "--mirrored").status == 0
    assert {event["name"] for event in events(*asked, "kick_left,kick_right")} == {"kick_left"}
