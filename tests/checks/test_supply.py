"""The check of what extras bring: its bill of materials, what counts as vulnerable, and what it does without a network."""

import json
import sys

import pytest

from checks import supply
from checks.supply import Part, audit, audited, bill, main, merged, resolve

pytest.importorskip("pip_audit", reason="pip-audit is not installed (dependency group dev)")


@pytest.fixture
def no_network(monkeypatch):
    for name in ("HTTPS_PROXY", "https_proxy", "HTTP_PROXY", "http_proxy", "ALL_PROXY"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")
    monkeypatch.setenv("PIP_CONFIG_FILE", "/dev/null")
    for name in ("PIP_EXTRA_INDEX_URL", "PIP_FIND_LINKS"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("PIP_INDEX_URL", "http://127.0.0.1:9/simple")
    monkeypatch.setenv("PIP_RETRIES", "0")


def run(monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["supply", *map(str, arguments)])
    return main()


@pytest.mark.usefixtures("no_network")
def test_without_an_index_it_says_so_and_passes(monkeypatch, tmp_path, capsys):
    assert run(monkeypatch, "--extras", "(none)", "--bom", tmp_path / "bom.json") == 0
    out = capsys.readouterr().out
    assert "not resolved, so not checked: (none): ERROR" in out
    assert "no bill is written" in out
    assert not (tmp_path / "bom.json").exists()
    assert run(monkeypatch, "--extras", "(none)", "--strict") == 1


@pytest.mark.usefixtures("no_network")
def test_without_anybody_to_ask_it_says_so():
    said = audit([Part("filelock", "3.12.0")])
    assert isinstance(said, str)
    assert said


@pytest.mark.parametrize(
    ("requirement", "mended_in", "status", "said"),
    [
        ("bad<1.1", ["1.1"], 1, "a limit of pyproject.toml keeps the mended version out"),
        ("bad<1.2", ["1.1"], 0, "held back by others"),
        ("other", ["1.1"], 0, "held back by others"),
        ("Bad<1.1", [], 0, "no version mends it"),
    ],
)
def test_only_a_vulnerability_that_can_be_mended_here_fails(
    monkeypatch, tmp_path, capsys, requirement, mended_in, status, said
):
    lines = ["[project]", f'dependencies = ["{requirement}"]', "[project.optional-dependencies]"]
    (tmp_path / "pyproject.toml").write_text("\n".join(lines))
    bad = {"name": "bad", "version": "1.0", "vulns": [{"id": "PYSEC-1", "fix_versions": mended_in}]}
    monkeypatch.setattr(supply, "ROOT", tmp_path)
    monkeypatch.setattr(supply, "resolve", lambda _, extra: [Part("bad", "1.0", extras=[extra])])
    monkeypatch.setattr(supply, "audit", lambda _: audited([bad]))
    assert run(monkeypatch) == status
    assert f"vulnerable, {said}: bad 1.0: PYSEC-1" in capsys.readouterr().out


class Answer:
    """What pip-audit prints."""

    stderr = ""

    def __init__(self, *dependencies):
        self.stdout = json.dumps({"dependencies": dependencies})


SKIPPED = {"name": "lost", "skip_reason": "Dependency not found on PyPI and could not be audited"}


def test_what_the_database_does_not_have_is_printed_as_not_checked(monkeypatch, capsys):
    monkeypatch.setattr(supply, "resolve", lambda *_: [Part("good", "1.0"), Part("lost", "1.0")])
    answer = Answer({"name": "good", "version": "1.0", "vulns": []}, SKIPPED)
    monkeypatch.setattr(supply.subprocess, "run", lambda *_, **__: answer)
    assert run(monkeypatch, "--extras", "view") == 0
    out = capsys.readouterr().out
    assert "not in the database, so not checked: lost" in out
    assert "1 of 2 distributions checked, 0 known vulnerabilities" in out
    assert run(monkeypatch, "--extras", "view", "--strict") == 1


def test_a_database_that_has_nothing_was_not_asked(monkeypatch):
    monkeypatch.setattr(supply.subprocess, "run", lambda *_, **__: Answer(SKIPPED))
    assert audit([Part("lost", "1.0")]) == "the database has none of the distributions"


def test_what_two_extras_bring_stands_once_in_the_bill():
    first, second = Part("numpy", "2.0", "ab", "BSD", ["view"]), Part("numpy", "2.0", "ab", "BSD", ["oak"])
    other = Part("numpy", "1.26", "cd", "BSD", ["flink"])
    parts = merged({"view": [first], "oak": [second], "flink": [other]})
    found = bill("mossar-stream", parts)
    assert (found["bomFormat"], found["specVersion"]) == ("CycloneDX", "1.5")
    assert [(one["purl"], [row["value"] for row in one["properties"]]) for one in found["components"]] == [
        ("pkg:pypi/numpy@1.26", ["flink"]),
        ("pkg:pypi/numpy@2.0", ["view", "oak"]),
    ]
    json.dumps(found)


@pytest.mark.usefixtures("no_network")
def test_a_requirement_that_nobody_has_is_told_and_not_raised():
    assert isinstance(resolve({"dependencies": ["filelock"], "optional-dependencies": {}}, "(none)"), str)
