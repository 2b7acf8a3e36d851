"""The demo in a terminal: what a newcomer reads."""

import io
import re

import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.pipeline import Pipeline
from mossar_stream import Settings
from mossar_tools.console import Console
from mossar_tools.story import Story


class Terminal(io.StringIO):
    """A place to write to that says it is a terminal."""

    encoding = "utf-8"

    def isatty(self):
        return True


def told(performers=1, seconds=20):
    """Return lines of a performance in a terminal, the words at the end, and what was drawn."""
    out, err = Terminal(), Terminal()
    console = Console(out, err)
    source = DemoSource.from_url(f"demo:?seconds={seconds}&seed=3&performers={performers}", speed="max")
    story = Story(console, [source], visible=True)
    pipeline = Pipeline([source], [], Settings(), views=[story], tick=lambda: story.tick(pipeline))
    pipeline.run()
    lines = re.sub(r"\x1b\[[\d;]*m", "", out.getvalue()).splitlines()
    return lines, story.summary(), err.getvalue()


@pytest.fixture(autouse=True)
def size(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("LINES", "40")


def test_each_key_frame_is_told_once_with_a_mark_where_it_is_true():
    lines, summary, _ = told()
    assert re.fullmatch(r"  0:0[12]\.\d  moving", lines[0])
    keys = [line for line in lines if "decided" in line]
    assert len(keys) == len(set(keys)) > 10
    assert all(re.search(r" [✓·] .* decided \d\.\d s later$", line) for line in keys)
    true = [line for line in keys if "✓" in line]
    assert re.search(r"✓ rest → jump", true[0])
    assert f"✓ {len(true)} of 7 changes" in summary[1]
    assert len(true) >= 6
    assert any("within jump" in line for line in keys)


def test_the_end_has_two_delays_and_the_next_command():
    _, summary, _ = told()
    text = " ".join(line.strip() for line in summary)
    assert re.search(r"\(activity\) were reported within 0\.\d\d s; .* \(final\) after 1\.\d s, median", text)
    commands = [line.split("  ")[1] for line in summary[summary.index("Next:") + 1 :]]
    assert commands == ["mossar view demo:", "mossar segment take.bvh", "mossar run 39539"]
    assert "%" not in text


@pytest.mark.parametrize(("columns", "later"), [(46, r" \+\d\.\d s$"), (80, r" decided \d\.\d s later$")])
def test_each_key_frame_says_when_it_was_decided(monkeypatch, columns, later):
    monkeypatch.setenv("COLUMNS", str(columns))
    keys = [line for line in told()[0] if re.search("[✓·]", line)]
    assert len(keys) > 10
    assert all(re.search(later, line) for line in keys)


@pytest.mark.parametrize("columns", [30, 46, 80])
def test_no_line_is_longer_than_the_terminal_is_wide(monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    lines, summary, drawn = told()
    assert max(map(len, [*lines, *summary])) <= columns
    shown = re.sub(r"\x1b\[\d*[AJ]", "\n", drawn).replace("\r", "\n").splitlines()
    assert max(map(len, shown)) <= columns


def test_the_performer_is_drawn_where_there_is_room_for_it(monkeypatch):
    assert re.search("[\u2801-\u28ff]", told()[2])
    monkeypatch.setenv("LINES", "12")
    low = told()[2]
    assert not re.search("[\u2801-\u28ff]", low)
    assert "p1 0:" in low


def test_several_performers_are_named_in_each_line():
    lines = told(performers=2)[0]
    assert {line.split()[0] for line in lines} == {"p1", "p2"}
