"""The check of what extras bring: its bill of materials, what counts as vulnerable, and what it does without a network."""

import json
import sys

import pytest

from checks import supply
from checks.supply import Part, audit, bill, main, merged, resolve, vulnerable

pytest.importorskip("pip_audit", reason="pip-audit is not installed (dependency group dev)")
BAD = {"name": "bad", "version": "1.0", "vulns": [{"id": "PYSEC-1", "fix_versions": ["1.1"]}]}


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


@pytest.mark.parametrize(("extra", "status"), [("view", 1), ("flink", 0)])
def test_a_known_vulnerability_fails_unless_others_hold_it_back(monkeypatch, capsys, extra, status):
    monkeypatch.setattr(supply, "resolve", lambda _, extra: [Part("bad", "1.0", extras=[extra])])
    monkeypatch.setattr(supply, "audit", lambda _: vulnerable([BAD]))
    assert run(monkeypatch, "--extras", extra) == status
    assert "bad 1.0: PYSEC-1, mended in 1.1" in capsys.readouterr().out


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
