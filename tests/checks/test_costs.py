import pytest

from checks import costs

SMALL = ["--minutes", "0.2", "0.4", "--slots", "5"]


def test_costs_are_printed(capsys, monkeypatch):
    monkeypatch.setattr(costs, "MOST_GROWTH", float("inf"))
    monkeypatch.setattr(costs, "MOST_SECONDS", float("inf"))
    assert costs.main(SMALL) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("5 slots: a usual frame ")
    assert [line.split(":")[0] for line in lines[1:-1]] == [f"recordings, {name}" for name in costs.KINDS]
    assert lines[-1] == "costs hold"


def squares(*of):
    return of[2] ** 2


def seconds(_count):
    return 0.001, 8.0


@pytest.mark.parametrize(
    ("name", "dear"),
    [
        ("cost_of_recording", squares),
        ("cost_of_slots", seconds),
    ],
)
def test_costs_that_grow_too_fast_are_an_error(capsys, monkeypatch, name, dear):
    monkeypatch.setattr(costs, "cost_of_recording", lambda *of: of[2])
    monkeypatch.setattr(costs, "cost_of_slots", lambda _: (0.001, 0.002))
    assert costs.main(["--minutes", "1", "8", "--slots", "5"]) == 0
    monkeypatch.setattr(costs, name, dear)
    assert costs.main(["--minutes", "1", "8", "--slots", "5"]) == 1
    assert "a cost grows too fast" in capsys.readouterr().out
