"""The command; see the package."""

import argparse
import time

from build_core import __doc__ as text
from build_core.extensions import build, variants


def main() -> None:
    """Compile outdated extensions, and print them."""
    parser = argparse.ArgumentParser(
        prog="python -m build_core", description=text, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--force", action="store_true", help="compile what is up to date, too")
    parser.add_argument("--strict", action="store_true", help="warnings are errors")
    parser.add_argument(
        "--sanitize", action="store_true", help="check addresses and undefined behaviour at run time"
    )
    parser.add_argument("--quick", action="store_true", help="optimise little: for a change to try")
    parser.add_argument("--only", choices=variants(), help="one of the two")
    options = parser.parse_args()
    began = time.perf_counter()
    built = build(
        is_strict=options.strict,
        is_sanitized=options.sanitize,
        is_forced=options.force,
        is_quick=options.quick,
        only=options.only,
    )
    for path, is_new in built.items():
        print(f"{path.name}: {'compiled' if is_new else 'up to date'}")
    print(f"{time.perf_counter() - began:.1f} s")


if __name__ == "__main__":
    main()
