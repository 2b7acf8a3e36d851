"""The distributions of each extra: known vulnerabilities, and a bill of materials (CycloneDX) for a release.

    python -m checks.supply                                        # ask pip-audit about the distributions of all extras
    python -m checks.supply --bom dist/mossar-stream.cdx.json      # and write the bill; part of making a release
    python -m checks.supply --extras view,oak

pip reports the present versions of each extra, and installs nothing; extras exclude one another, so each is resolved by
itself. Without an index, or a database of vulnerabilities, that is printed, and the status is 0: machines without a network
run the same checks; `--strict` makes it 1. The same holds for distributions that the database does not have.

Ends with status 1 if a version has a known vulnerability, a later version mends it, and a limit of pyproject.toml keeps that
version out: raise the limit. Vulnerabilities that no version mends, or that other requirements hold back, are printed, and
the status is 0: a commit does not turn red for causes outside it.
"""

import argparse
import itertools
import json
import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import msgspec
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[2]
PATIENCE = 300.0  # s, for one extra
AT_ONCE = 4
SHOWN = 10  # names of distributions in a line
PLAIN = "(none)"  # name of the requirements without any extra
OURS = "a limit of pyproject.toml keeps the mended version out"


class Part(msgspec.Struct, order=True):
    """A distribution that an extra brings.

    Args:
        name: Normalised.
        version: Which pip would install.
        sha256: Of its archive, if the index has it.
        licence: As the distribution states it.
        extras: That bring it.
    """

    name: str
    version: str
    sha256: str = ""
    licence: str = ""
    extras: list[str] = []


class Vulnerability(msgspec.Struct, frozen=True, order=True):
    """A known vulnerability of a version.

    Args:
        name: Of the distribution.
        version: The same.
        known_as: In the database.
        mended_in: Versions without it.
    """

    name: str
    version: str
    known_as: str
    mended_in: tuple[str, ...] = ()

    @property
    def line(self) -> str:
        """The printed line."""
        return f"{self.name} {self.version}: {self.known_as}, mended in {', '.join(self.mended_in) or 'no version'}"


class Audit(msgspec.Struct, frozen=True):
    """Result of pip-audit.

    Args:
        vulnerable: The vulnerabilities, in the order of names.
        unknown: Names and versions that the database does not have.
    """

    vulnerable: list[Vulnerability] = []
    unknown: list[str] = []


def main() -> int:
    """Run the checks of the command line; return the exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--bom", metavar="FILE", type=Path, help="write a bill of materials")
    parser.add_argument("--extras", metavar="LIST", help="only these, with commas between them")
    parser.add_argument("--strict", action="store_true", help="status 1 if something could not be checked")
    options = parser.parse_args()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = options.extras.split(",") if options.extras else [PLAIN, *project["optional-dependencies"]]
    with ThreadPoolExecutor(AT_ONCE) as pool:
        resolved = dict(zip(wanted, pool.map(lambda extra: resolve(project, extra), wanted), strict=True))
    missing = [f"{extra}: {found}" for extra, found in resolved.items() if isinstance(found, str)]
    parts = merged({extra: found for extra, found in resolved.items() if not isinstance(found, str)})
    for line in missing:
        print(f"not resolved, so not checked: {line}")
    if options.bom is not None and parts and not missing:
        options.bom.parent.mkdir(parents=True, exist_ok=True)
        options.bom.write_text(json.dumps(bill(project["name"], parts), indent=1) + "\n", encoding="utf-8")
        print(f"{options.bom}: {len(parts)} distributions of {len(resolved)} sets of requirements")
    elif options.bom is not None:
        print(f"{options.bom}: no bill is written, because something could not be resolved")
    found = audit(parts) if parts else "there is nothing to ask about"
    if isinstance(found, str):
        print(f"vulnerabilities were not asked for: {found}")
        return int(options.strict)
    verdicts = [verdict(project, bad) for bad in found.vulnerable]
    for bad, said in zip(found.vulnerable, verdicts, strict=True):
        print(f"vulnerable, {said}: {bad.line}")
    if found.unknown:
        more = len(found.unknown) - SHOWN
        names = ", ".join(found.unknown[:SHOWN]) + (f" and {more} more" if more > 0 else "")
        print(f"not in the database, so not checked: {names}")
    checked = len(parts) - len(found.unknown)
    print(f"{checked} of {len(parts)} distributions checked, {len(verdicts)} known vulnerabilities")
    return int(OURS in verdicts or (options.strict and bool(missing or found.unknown)))


def verdict(project: dict[str, Any], bad: Vulnerability) -> str:
    """Return the reason why a vulnerable version stays in use; pip has chosen the latest one that all requirements allow."""
    if not bad.mended_in:
        return "no version mends it"
    every = [*project["dependencies"], *itertools.chain(*project["optional-dependencies"].values())]
    limits = [one.specifier for one in map(Requirement, every) if _normal(one.name) == _normal(bad.name)]
    kept_out = any(not any(limit.contains(version) for version in bad.mended_in) for limit in limits)
    return OURS if kept_out else "held back by others"


def _of_extra(project: dict[str, Any], extra: str) -> list[str]:
    """Return the requirements of an extra; those of other extras in place of the project's own name."""
    found: list[str] = []
    for text in project["optional-dependencies"].get(extra, ()):
        wanted = Requirement(text)
        own = wanted.extras if _normal(wanted.name) == _normal(project.get("name", "")) else ()
        found += [one for other in sorted(own) for one in _of_extra(project, other)] if own else [text]
    return list(dict.fromkeys(found))


def resolve(project: dict[str, Any], extra: str) -> list[Part] | str:
    """Return the distributions that pip would install for an extra, or an error."""
    requirements = [*project["dependencies"], *_of_extra(project, extra)]
    command = [sys.executable, "-m", "pip", "install", "--dry-run", "--ignore-installed", "--quiet"]
    command += ["--disable-pip-version-check", "--no-input", "--report", "-", *requirements]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)  # noqa: S603
    except subprocess.TimeoutExpired:
        return f"pip took longer than {PATIENCE:.0f} s"
    if done.returncode != 0:
        said = [line for line in done.stderr.splitlines() if line.startswith("ERROR")]
        return said[-1] if said else f"pip ended with status {done.returncode}"
    return [_part(item, extra) for item in json.loads(done.stdout)["install"]]


def _part(item: dict[str, Any], extra: str) -> Part:
    facts = item["metadata"]
    classified = [one for one in facts.get("classifier", ()) if one.startswith("License ::")]
    licence = facts.get("license_expression") or (classified[0].rpartition(" :: ")[2] if classified else "")
    hashes = item["download_info"].get("archive_info", {}).get("hashes", {})
    return Part(_normal(facts["name"]), facts["version"], hashes.get("sha256", ""), licence, [extra])


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def merged(resolved: dict[str, list[Part]]) -> list[Part]:
    """Return every version of every distribution once, in the order of their names."""
    found: dict[tuple[str, str], Part] = {}
    for extra, parts in resolved.items():
        for part in parts:
            known = found.setdefault((part.name, part.version), msgspec.structs.replace(part, extras=[]))
            known.extras.append(extra)
    return sorted(found.values())


def bill(name: str, parts: Sequence[Part]) -> dict[str, Any]:
    """Return a bill of materials as CycloneDX 1.5 has it."""
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": {"type": "library", "name": name, "bom-ref": name}},
        "components": [_component(part) for part in parts],
    }


def _component(part: Part) -> dict[str, Any]:
    purl = f"pkg:pypi/{part.name}@{part.version}"
    component: dict[str, Any] = {
        "type": "library",
        "name": part.name,
        "version": part.version,
        "purl": purl,
        "bom-ref": purl,
        "properties": [{"name": "mossar:extra", "value": extra} for extra in part.extras],
    }
    if part.sha256:
        component["hashes"] = [{"alg": "SHA-256", "content": part.sha256}]
    if part.licence:
        component["licenses"] = [{"license": {"name": part.licence}}]
    return component


def audit(parts: Sequence[Part]) -> Audit | str:
    """Return the result of pip-audit, or an error."""
    said: list[dict[str, Any]] = []
    for pinned in _without_doubles(parts):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "requirements.txt")
            path.write_text("".join(f"{part.name}=={part.version}\n" for part in pinned), encoding="utf-8")
            command = [sys.executable, "-m", "pip_audit", "--disable-pip", "--no-deps", "--format", "json"]
            command += ["--progress-spinner", "off", "--requirement", str(path)]
            try:
                done = subprocess.run(  # noqa: S603
                    command, capture_output=True, text=True, timeout=PATIENCE, check=False
                )
                said += json.loads(done.stdout)["dependencies"]
            except subprocess.TimeoutExpired:
                return f"pip-audit took longer than {PATIENCE:.0f} s"
            except (ValueError, KeyError):
                return (done.stderr.strip().splitlines() or ["pip-audit said nothing"])[-1][:200]
    known = audited(said)
    return known if len(known.unknown) < len(parts) else "the database has none of the distributions"


def _without_doubles(parts: Sequence[Part]) -> list[list[Part]]:
    """Return parts in lists in which each name stands once, because extras may bring other versions of the same."""
    lists: list[list[Part]] = []
    for part in parts:
        place = next((own for own in lists if all(part.name != other.name for other in own)), None)
        if place is None:
            lists.append([part])
        else:
            place.append(part)
    return lists


def audited(said: Sequence[dict[str, Any]]) -> Audit:
    """Return the audit of pip-audit's output; it skips distributions that the database does not have."""
    bad = {
        Vulnerability(one["name"], one["version"], bad["id"], tuple(bad["fix_versions"]))
        for one in said
        for bad in one.get("vulns", ())
    }
    return Audit(sorted(bad), sorted({one["name"] for one in said if "skip_reason" in one}))


if __name__ == "__main__":
    sys.exit(main())
