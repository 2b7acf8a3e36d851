"""What is large is listed, and nothing is refused for it."""

from checks import sizes


def test_long_files_functions_and_large_packages_are_listed(tmp_path, capsys, monkeypatch):
    body = "def long():\n" + "    x = 1\n" * sizes.LONGEST_FUNCTION + "\n\ndef short():\n    return 1\n"
    for number in range(sizes.MOST_MODULES + 1):
        (tmp_path / f"m{number}.py").write_text("")
    (tmp_path / "m0.py").write_text(body + "y = 2\n" * sizes.LONGEST_FILE)
    monkeypatch.setattr("sys.argv", ["sizes", str(tmp_path)])
    assert sizes.main() == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    lines = len((tmp_path / "m0.py").read_text().splitlines())
    assert [(int(size), kind) for size, kind, *_ in rows] == [
        (sizes.MOST_MODULES + 1, "modules"),
        (lines, "lines"),
        (sizes.LONGEST_FUNCTION + 1, "lines"),
    ]
    assert rows[-1][-1] == "long"


def test_a_tree_without_large_parts_has_no_row(tmp_path, capsys, monkeypatch):
    (tmp_path / "small.py").write_text("x = 1\n")
    monkeypatch.setattr("sys.argv", ["sizes", str(tmp_path)])
    assert sizes.main() == 0
    assert capsys.readouterr().out == ""
