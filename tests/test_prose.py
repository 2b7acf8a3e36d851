"""Words that the project has agreed to avoid stay rare in documentation, docstrings, comments and messages."""

import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[1]
AVOIDED = re.compile(
    r"\b(is|are|was|were|be) (told|said) (of|by|to|at)\b|\bwhoever\b|\bit is said\b|\btaken in\b|\bgoes before\b|\btold of\b",
    re.IGNORECASE,
)
MOST = 20


def texts():
    """Yield (path, text on one line) of pages, programs and the schema; lab notes quote, tests are named as they like."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in listed.splitlines():
        path = ROOT / name
        if name.startswith(("tests/", "docs/lab-notes/")) or path.suffix not in {
            ".md",
            ".py",
            ".json",
            ".toml",
        }:
            continue
        yield name, re.sub(r"\s+(?:# )?", " ", path.read_text())


def test_words_to_be_avoided_are_rare():
    found = [
        f"{name}: ...{text[max(0, hit.start() - 40) : hit.end() + 20]}..."
        for name, text in texts()
        for hit in AVOIDED.finditer(text)
    ]
    assert len(found) <= MOST, "\n".join(found)


def test_the_readme_is_short_and_leads_each_reader_to_a_first_command():
    lines = (ROOT / "README.md").read_text().splitlines()
    assert len(lines) <= 180
    first = "\n".join(lines[:36])  # a screen
    assert "mossar demo" in first
    assert "docs/segment.png" in first
    for command in ("mossar run osc://", "mossar view webcam:", "mossar segment take.bvh"):
        assert command in first
