"""Commands of the documentation are found, and judged as they deserve."""

from checks.readme_commands import (
    Command,
    Stage,
    _lines,
    all_commands,
    humanoid,
    parts_of,
    wrong_mentions,
)
from mossar_adapters.files import open_recording


def test_commands_are_found_and_prose_is_not():
    found = {command.line for command in all_commands()}
    assert "mossar segment take.bvh --csv take.csv" in found
    assert "mossar bench --only stream,push" in found
    assert all(line.startswith(("mossar", "python", "pip", "flink", "eval")) for line in found)


def test_blocks_of_other_languages_are_no_commands():
    blocks, text = parts_of("a\n```json\n{}\n```\nb\n```\nmossar demo   # c\n```\n")
    assert blocks == [["mossar demo   # c"]]
    assert text == "a\nb"
    assert list(_lines(blocks[0])) == ["mossar demo"]
    assert list(_lines(["$ mossar demo", '{"type":"stream"}'])) == ["mossar demo"]


def test_running_text_mentions_only_what_there_is():
    assert list(wrong_mentions()) == []


def test_commands_are_judged(tmp_path):
    stage = Stage(tmp_path, 120.0)
    assert stage.run(Command("x", "mossar --version")) == ""
    assert stage.run(Command("x", "mossar segment nowhere.bvh")).startswith(
        "WRONG: status 2: mossar: error: "
    )
    assert stage.run(Command("x", "rm -r everything")).startswith("WRONG: no command")
    hasty = Stage(tmp_path / "other", 2.0)
    assert hasty.run(Command("x", "python -c 'import time; time.sleep(99)'")) == "goes on until Ctrl-C"


def test_the_stand_in_is_a_recording(tmp_path):
    (tmp_path / "a.bvh").write_bytes(humanoid(30))
    recording = open_recording(tmp_path / "a.bvh")
    assert len(recording.skeleton) >= 8
    assert sum(len(frames) for frames in recording.chunks()) == 30
