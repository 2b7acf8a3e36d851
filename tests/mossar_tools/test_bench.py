import json

import pytest

from mossar_tools.bench.measures import MEASURES
from mossar_tools.cli import main
from mossar_tools.commands.bench import EXAMPLES


def test_everything_is_measured_and_put_out(capsys, tmp_path):
    report, picture = tmp_path / "speed.json", tmp_path / "speed.svg"
    arguments = ["bench", "--quick", "--json", str(report), "--plot", str(picture)]
    assert main([*arguments, "--csv", str(tmp_path / "speed.csv")]) == 0
    shown = capsys.readouterr().out
    found = json.loads(report.read_text())
    assert {row["part"] for row in found["measurements"]} == set(MEASURES)
    for row in found["measurements"]:
        assert row["min"] <= row["median"] <= row["max"]
        assert row["name"] in shown
    assert {"cpu", "cores", "versions", "load", "others"} <= set(found["machine"])
    assert "numpy" in shown
    assert "loaded the machine" in shown
    assert picture.stat().st_size > 10_000


def test_a_recording_is_measured_beside_the_performer(capsys, swing):
    assert main(["bench", str(swing), "--quick", "--only", "stream"]) == 0
    shown = capsys.readouterr().out
    assert "1 real recordings, 4 joints" in shown
    assert "built-in performer" in shown


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--only", "speed"], "nothing is called 'speed'"),
        (["--only", "limbs"], "python -m checks.speed --only limbs, from a checkout"),
        (["nowhere.bvh"], "nowhere.bvh"),
        (["--plot", "speed.gif"], "pictures are"),
    ],
)
def test_wrong_usage_is_one_line_and_status_2(capsys, arguments, problem):
    assert main(["bench", *arguments]) == 2
    err = capsys.readouterr().err
    assert problem in err
    assert len(err.splitlines()) == 1


def test_the_help_names_every_part():
    assert f"the parts: {' '.join(MEASURES)}\n" in EXAMPLES
