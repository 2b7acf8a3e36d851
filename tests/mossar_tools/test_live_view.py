"""The table of key frames in terminals of any width."""

import io

import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.pipeline import Pipeline
from mossar_stream import Settings
from mossar_tools.console import Console
from mossar_tools.live_view import LiveView


def table(encoding="utf-8", performers=1):
    """Return what the terminal shows of a performance."""
    raw = io.BytesIO()
    out = io.TextIOWrapper(raw, encoding=encoding, newline="")
    source = DemoSource.from_url(f"demo:?seconds=20&seed=3&performers={performers}", speed="max")
    view = LiveView(Console(out, io.StringIO()), [source], visible=True)
    Pipeline([source], [view], Settings(), views=[view]).run()
    out.flush()
    return raw.getvalue().decode(encoding).splitlines()


@pytest.mark.parametrize("encoding", ["utf-8", "ascii"])
@pytest.mark.parametrize("columns", [20, 28, 39, 40, 52, 60, 74, 75, 80, 132])
def test_no_line_is_longer_than_the_terminal_is_wide(monkeypatch, columns, encoding):
    monkeypatch.setenv("COLUMNS", str(columns))
    lines = table(encoding)
    assert len(lines) > 10
    assert max(map(len, lines)) <= columns
    times = [line for line in lines if "confi" in line]
    assert times
    assert all(" s " in line for line in times)


def test_a_wide_terminal_has_all_columns_and_a_narrow_one_the_most_important(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert table()[0].split() == ["performer", "time", "frame", "key", "frame", "kind", "delay", "velocity"]
    monkeypatch.setenv("COLUMNS", "59")
    assert table()[0].split() == ["performer", "time", "key", "frame", "kind", "delay"]
    monkeypatch.setenv("COLUMNS", "40")
    assert table()[0].split() == ["performer", "time", "key", "frame"]
