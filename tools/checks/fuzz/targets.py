"""All targets in one list."""

from pathlib import Path

from checks.fuzz.files import file_targets
from checks.fuzz.sealed import sealed_targets
from checks.fuzz.states import state_targets
from checks.fuzz.target import Target
from checks.fuzz.trees import drawn_targets
from checks.fuzz.wires import wire_targets
from checks.fuzz.words import word_targets


def all_targets(samples: Path | None = None) -> list[Target]:
    """Return the targets.

    Args:
        samples: Folder of recordings to be damaged besides those that are made here.
    """
    made = [*wire_targets(), *word_targets(), *state_targets(), *sealed_targets(), *file_targets(samples)]
    return [*made, *drawn_targets(made)]
