"""Commands of the documentation are found, and judged as they deserve."""

import socket

from checks.readme_commands.commands import (
    Command,
    all_commands,
    lines_of,
    parts_of,
    steps_of,
    wrong_mentions,
)
from checks.readme_commands.files import furnish
from checks.readme_commands.stage import Stage, ports_of
from mossar_adapters.files import read


def test_commands_are_found_and_prose_is_not():
    found = {command.line for command in all_commands()}
    assert "mossar segment take.bvh --csv take.csv" in found
    assert "mossar bench --only stream,push" in found
    assert all(line.startswith(("mossar", "python", "pip", "flink", "eval")) for line in found)


def test_blocks_of_other_languages_are_no_commands():
    blocks, text = parts_of("a\n```json\n{}\n```\nb\n```\nmossar demo   # c\n```\n")
    assert blocks == [["mossar demo   # c"]]
    assert text == "a\nb"
    assert list(lines_of(blocks[0])) == ["mossar demo"]
    assert list(lines_of(["$ mossar demo", '{"type":"stream"}'])) == ["mossar demo"]


def test_running_text_mentions_only_what_there_is():
    assert list(wrong_mentions()) == []


def test_a_command_that_stands_in_several_places_is_run_once():
    lines = [command.line for command in all_commands() if not command.series]
    assert len(lines) == len(set(lines))
    places = {command.line: command.place for command in all_commands() if not command.series}
    assert places["mossar evaluate DIR --plot strips.png"] == "mossar evaluate --help"
    assert places["mossar bench"] == "docs/measurements.md, mossar bench --help"


def test_commands_are_judged(tmp_path):
    stage = Stage(tmp_path / "a", 2.0, 120.0)
    assert stage.run(Command("x", "mossar --version")) == ""
    assert stage.run(Command("x", "mossar segment nowhere.bvh")).startswith(
        "WRONG: status 2: mossar: error: "
    )
    assert stage.run(Command("x", "rm -r everything")).startswith("WRONG: no command")
    assert stage.run(Command("x", "python -m checks.echo osc 0 9")) == "goes on until Ctrl-C"
    assert stage.run(Command("x", "python -c 'exit(3)' | cat")).startswith("WRONG: status 3")
    assert stage.run(Command("x", "python -c '' | cat")).startswith("WRONG: nothing comes out")
    assert stage.run(Command("x", "mossar demo | head -1")) == ""


def test_ports_of_a_configuration_file_are_known(tmp_path):
    (tmp_path / "stage.toml").write_text('sources = ["osc://127.0.0.1:39539"]')
    assert ports_of("mossar run --config stage.toml --to ws://127.0.0.1:8765", tmp_path) == ["39539", "8765"]
    assert ports_of("mossar run --config none.toml", tmp_path) == []


def test_a_command_whose_port_is_in_use_is_run_again(tmp_path):
    reports = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as busy:
        busy.bind(("127.0.0.1", 0))
        command = Command("x", f"mossar run osc://127.0.0.1:{busy.getsockname()[1]}")

        class FreedAfterwards(Stage):
            def _judged(self, *given):
                reports.append(super()._judged(*given))
                busy.close()
                return reports[-1]

        assert FreedAfterwards(tmp_path / "a", 15.0, 120.0).run(command) == "goes on until Ctrl-C"
    assert len(reports) == 2
    assert "is in use" in reports[0]


def test_what_should_end_by_itself_and_what_ignores_ctrl_c_is_wrong(tmp_path):
    stage = Stage(tmp_path / "a", 2.0, 2.0)
    assert stage.run(Command("x", "python -c 'import time; time.sleep(99)'")).startswith("WRONG: it had not")


def test_the_stand_ins_are_recordings(tmp_path):
    furnish(tmp_path / "a")
    for name in ("take.bvh", "86_01.amc", "take.c3d", "take.msk", "DIR/walk.npz"):
        assert len(read(tmp_path / "a" / name).times) >= 30, name
    assert read(tmp_path / "a" / "long.bvh").times[-1] > 660


def test_a_tutorial_is_run_in_order_and_in_one_folder(tmp_path):
    page = "```\n$ mossar demo\n{}\n```\ntext\n```python\nprint(1)\n```\n```json\n{}\n```\n```\nmossar --version\n```\n"
    assert list(steps_of(page)) == ["mossar demo", "python - <<'END'\nprint(1)\nEND", "mossar --version"]
    stage = Stage(tmp_path / "a", 2.0, 120.0)
    assert stage.run(Command("x", "python - <<'END'\nopen('made', 'w').close()\nEND", "series")) == ""
    assert stage.run(Command("x", "python -c \"open('made')\"", "series")) == ""
    assert stage.run(Command("x", "python -c \"open('made')\"")).startswith("WRONG")
    series = [command.line for command in all_commands() if command.series == "docs/tutorials/game.md"]
    assert series.index("mossar teach moves.json --list") > 0
