"""The label files to compare: single files, or those of the same names in folders, and the tier of each."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from mossar_adapters.annotations.reading import SUFFIXES, read_annotations
from mossar_adapters.annotations.tiers import KEY_FRAMES, MOVES, SEGMENTS, STEPS, Tier
from mossar_tools.console import LOGGER
from mossar_tools.errors import UsageError

# Of several common tiers the first of these.
_USUAL = (
    f"{SEGMENTS} motion",
    SEGMENTS,
    MOVES,
    KEY_FRAMES,
    STEPS,
)


def recordings_of(sources: Sequence[str]) -> dict[str, list[Path]]:
    """Return the files of each recording, one for each labeller, by the recording's name.

    Args:
        sources: Of each labeller a file, or a folder in which files are called after their recordings.

    Raises:
        UsageError: If files and folders are mixed, or no name is in all folders.
    """
    paths = [Path(source) for source in sources]
    missing = next((path for path in paths if not path.exists()), None)
    if missing is not None:
        raise UsageError(f"{missing}: there is no such file or folder")
    if not any(path.is_dir() for path in paths):
        return {paths[0].stem: paths}
    if not all(path.is_dir() for path in paths):
        raise UsageError(
            "some are files and some are folders; compare files with files, or folders with folders"
        )
    found = [_files_of(path) for path in paths]
    common = [name for name in found[0] if all(name in own for own in found)]
    if not common:
        raise UsageError(f"no recording is labelled in all folders; {paths[0]} has {_some(found[0])}")
    for path, own in zip(paths, found, strict=True):
        for name in sorted(own.keys() - set(common)):
            LOGGER.warning(
                "%s: skipped, because another folder has no labels of %s", path / own[name].name, name
            )
    return {name: [own[name] for own in found] for name in common}


def _files_of(folder: Path) -> dict[str, Path]:
    found: dict[str, Path] = {}
    for path in sorted(folder.iterdir()):
        if path.suffix.lower() in SUFFIXES and path.is_file():
            if path.stem in found:
                raise UsageError(f"{path}: {found[path.stem].name} has labels of the same recording")
            found[path.stem] = path
    return found


def _some(names: Mapping[str, Path]) -> str:
    return ", ".join(list(names)[:5]) or "none"


def tiers_of(paths: Sequence[Path], wanted: Sequence[str]) -> list[Tier]:
    """Return the tier of each file that is compared.

    Args:
        paths: Of one recording, a file for each labeller.
        wanted: A name for all, or one for each; none takes the tier that all have in common, or the only one of each.

    Raises:
        MossarError: If a file cannot be read, or the wanted tier is not clear.
    """
    if len(wanted) not in {0, 1, len(paths)}:
        raise UsageError(f"--tier names one tier, or one for each of the {len(paths)} labellers")
    files = [{tier.name: tier for tier in read_annotations(path)} for path in paths]
    names = list(wanted) * (len(paths) if len(wanted) == 1 else 1) or _names_in(paths, files)
    for path, own, name in zip(paths, files, names, strict=True):
        if name not in own:
            raise UsageError(f"{path}: there is no tier called {name}; there are: {', '.join(own) or 'none'}")
    chosen = [own[name] for own, name in zip(files, names, strict=True)]
    if len({tier.moments for tier in chosen if tier.marks}) > 1:
        raise UsageError(
            f"{paths[0]}: moments are compared with moments, stretches with stretches; choose with --tier"
        )
    return chosen


def _names_in(paths: Sequence[Path], files: Sequence[Mapping[str, Tier]]) -> list[str]:
    common = [name for name in files[0] if all(name in own for own in files)]
    chosen = next((name for name in _USUAL if name in common), common[0] if len(common) == 1 else None)
    if chosen is not None:
        return [chosen] * len(files)
    if all(len(own) == 1 for own in files):
        return [next(iter(own)) for own in files]
    there = "; ".join(
        f"{path.name} has {', '.join(own) or 'none'}" for path, own in zip(paths, files, strict=True)
    )
    raise UsageError(f"which tiers? {there}; name one, or one for each, with --tier")
