"""The hook that hatchling calls for a wheel and for an editable install."""

import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

sys.path.insert(0, str(Path(__file__).parents[1]))  # hatchling loads this file alone

from build_core.compiler import ZIG, configured
from build_core.extensions import REQUIRED, build


class CompileCore(BuildHookInterface[Any]):
    """Compiles the core in place, and puts the extensions into the wheel."""

    def dependencies(self) -> list[str]:
        """Return the requirements of compiling; zig only where there is no compiler."""
        return [*REQUIRED, *([] if configured() else [ZIG])]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile; the wheel is for this system and this Python.

        Args:
            version: `standard` or `editable`; both have the extensions beside the sources.
            build_data: Content of the wheel for hatchling.
        """
        del version
        built = build()
        build_data["pure_python"], build_data["infer_tag"] = False, True
        build_data["artifacts"] += [path.relative_to(self.root).as_posix() for path in built]
