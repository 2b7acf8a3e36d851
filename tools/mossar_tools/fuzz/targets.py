"""All targets in one list."""

from pathlib import Path

from mossar_tools.fuzz.files import file_targets
from mossar_tools.fuzz.states import state_targets
from mossar_tools.fuzz.target import Target
from mossar_tools.fuzz.trees import drawn_targets
from mossar_tools.fuzz.wires import wire_targets
from mossar_tools.fuzz.words import word_targets


def all_targets(samples: Path | None = None) -> list[Target]:
    """Return the targets.

    Args:
        samples: Folder of recordings to be damaged besides those that are made here.
    """
    made = [*wire_targets(), *word_targets(), *state_targets(), *file_targets(samples)]
    return [*made, *drawn_targets(made)]
