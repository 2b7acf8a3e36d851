"""What is large is listed, and nothing is refused for it."""

from checks import sizes


def test_long_files_functions_and_large_packages_are_listed(tmp_path, capsys, monkeypatch):
    body = "def long():\n" + "    x = 1\n" * sizes.LONGEST_FUNCTION + "\n\ndef short():\n    return 1\n"
    for number in range(sizes.MOST_MODULES + 1):
        (tmp_path / f"m{number}.py").write_text("")
    (tmp_path / "m0.py").write_text(body + "y = 2\n" * sizes.LONGEST_FILE)
    kernel = (
        "cdef void longer(\n    int64_t count\n) noexcept nogil:\n" + "    pass\n" * sizes.LONGEST_FUNCTION
    )
    (tmp_path / "m1.py").rename(tmp_path / "m1.pxi")
    (tmp_path / "m1.pxi").write_text(kernel + "\n\ncdef int64_t short_one():\n    return 1\n")
    monkeypatch.setattr("sys.argv", ["sizes", str(tmp_path)])
    assert sizes.main() == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    lines = len((tmp_path / "m0.py").read_text().splitlines())
    assert [(int(size), kind) for size, kind, *_ in rows] == [
        (sizes.MOST_MODULES + 1, "modules"),
        (lines, "lines"),
        (sizes.LONGEST_FUNCTION + 3, "lines"),
        (sizes.LONGEST_FUNCTION + 1, "lines"),
    ]
    assert [row[-1] for row in rows[-2:]] == ["longer", "long"]


def test_a_tree_without_large_parts_has_no_row(tmp_path, capsys, monkeypatch):
    (tmp_path / "small.py").write_text("x = 1\n")
    monkeypatch.setattr("sys.argv", ["sizes", str(tmp_path)])
    assert sizes.main() == 0
    assert capsys.readouterr().out == ""
