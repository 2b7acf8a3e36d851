"""Commands of the documentation, and the names that its text mentions."""

import functools
import importlib.util
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from mossar_tools.cli import COMMANDS, command_called
from mossar_tools.parser import parser_of

ROOT = Path(__file__).parents[3]
PAGES = (
    "README.md",
    "CONTRIBUTING.md",
    "SECURITY.md",
    *sorted(f"docs/{p.name}" for p in (ROOT / "docs").glob("*.md")),
)
TUTORIALS = tuple(sorted(f"docs/tutorials/{p.name}" for p in (ROOT / "docs" / "tutorials").glob("*.md")))
# Of pip, and of checks.false_moves and checks.following.
OTHERS = frozenset({"--group", "--as-shown", "--foreign"})
COMMENT = re.compile(r"\s{2,}|\s+#\s")


class Command(NamedTuple):
    """A line that a reader may type, or a program of several lines.

    Args:
        place: Where it stands; several places are separated by commas.
        line: As it stands there, without its comment.
        series: Commands of one series share a folder and run in order; each of the others has a folder of its own.
    """

    place: str
    line: str
    series: str = ""


def all_commands() -> list[Command]:
    """Return the commands of all pages and of every `--help`, each once, then those of each tutorial in order."""
    places: dict[str, list[str]] = {}
    for place, line in _everywhere():
        places.setdefault(line, []).append(place)
    once = [Command(", ".join(dict.fromkeys(where)), line) for line, where in places.items()]
    return once + [
        Command(page, line, page) for page in TUTORIALS for line in steps_of((ROOT / page).read_text())
    ]


def _everywhere() -> Iterator[tuple[str, str]]:
    for page in PAGES:
        fenced, _ = parts_of((ROOT / page).read_text())
        yield from ((page, line) for block in fenced for line in lines_of(block))
    for name in COMMANDS:
        block = command_called(name).EXAMPLES.splitlines()
        yield from ((f"mossar {name} --help", line) for line in lines_of(block))


def parts_of(page: str) -> tuple[list[list[str]], str]:
    """Return the lines of each fenced block that names no language, and the running text."""
    blocks: list[list[str]] = []
    text: list[str] = []
    fence: str | None = None
    for line in page.splitlines():
        if line.startswith("```"):
            fence = line[3:] if fence is None else None
            if fence == "":
                blocks.append([])
        elif fence is None:
            text.append(line)
        elif fence == "":
            blocks[-1].append(line)
    return blocks, "\n".join(text)


def steps_of(page: str) -> Iterator[str]:
    """Yield the commands of a page and its programs in Python, in order."""
    for language, text in re.findall(r"^```(\w*)\n(.*?)^```$", page, re.MULTILINE | re.DOTALL):
        if language == "python":
            yield f"python - <<'END'\n{text}END"
        elif not language:
            yield from lines_of(text.splitlines())


def lines_of(block: Sequence[str]) -> Iterator[str]:
    """Yield the commands of a block, without prompts, comments, and their output."""
    prompted = any(line.startswith("$ ") for line in block)
    for line in block:
        if line.strip() and (line.startswith("$ ") or not prompted):
            yield COMMENT.split(line.strip().removeprefix("$ "))[0]


def wrong_mentions() -> Iterator[tuple[str, str]]:
    """Yield mentions of missing commands, options and modules in running text."""
    for page in (*PAGES, *TUTORIALS):
        _, text = parts_of((ROOT / page).read_text())
        for problem in (*_wrong_commands(text), *_wrong_options(text), *_wrong_modules(text)):
            yield page, problem


def _wrong_commands(text: str) -> Iterator[str]:
    for mention in re.findall(r"`mossar\s+([a-z][^`]*)`", text):  # may go on in the next line
        name, *rest = mention.split()
        if name not in COMMANDS:
            yield f"`mossar {mention}`: there is no such command"
            continue
        for word in rest:
            if word.startswith("--") and word.partition("=")[0] not in _options(name):
                yield f"`mossar {mention}`: there is no {word}"


def _wrong_options(text: str) -> Iterator[str]:
    own = "\n".join(line for line in text.splitlines() if "python -m checks" not in line)
    known = OTHERS.union(*map(_options, COMMANDS))
    for option in re.findall(r"`(--[a-z][a-z0-9-]*)", own):
        if option not in known:
            yield f"`{option}`: no command has it"


def _wrong_modules(text: str) -> Iterator[str]:
    for name in re.findall(r"python -m ((?:checks|mossar_tools)[.\w]*)", text):
        if importlib.util.find_spec(name) is None:
            yield f"`python -m {name}`: there is no such module"


@functools.cache
def _options(name: str) -> frozenset[str]:
    """Return the options of a command."""
    parser = parser_of(f"mossar {name}", command_called(name))
    return frozenset(option for action in parser._actions for option in action.option_strings)  # noqa: SLF001
