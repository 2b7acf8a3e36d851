"""Tricks: `python -m checks.speed.tricks [NAME ...]` says what each trick of `mossar_stream.jit` gains.

A trick stays only while it gains more than a tenth of what it touches. Each is taken away in a process of its own,
which compiles everything anew, and compared with one that has them all. The results must be the same.
"""

import argparse
import hashlib
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import checks.reference.simd
import checks.reference.views
from mossar_stream.jit import cache, decorators, linked, options, precompile, simd, views

ALL = "all tricks"
RUNS = 7  # of which the quickest counts
SECONDS = 60.0  # of motion
CHUNK = 1000


def _counting(*, makes_arrays: bool) -> dict[str, Any]:  # noqa: ARG001 - as the one it replaces
    return options.entry_options(makes_arrays=True)


def _called(*, inline: bool = False, returns_views: bool = False) -> dict[str, Any]:  # noqa: ARG001
    return options.inner_options(returns_views=returns_views)


def _finished(*, inline: bool = False, returns_views: bool = False) -> dict[str, Any]:
    own = options.inner_options(inline=inline, returns_views=returns_views)
    return {name: value for name, value in own.items() if name != "pipeline_class"}


def _numpy_views() -> None:
    vars(views)["part"] = checks.reference.views.part
    vars(decorators)["entry_options"] = _counting


def _reference(name: str) -> Callable[[], None]:
    return lambda: vars(simd).update({name: getattr(checks.reference.simd, name)})


def _replace(module: Any, name: str, value: object) -> Callable[[], None]:
    return lambda: vars(module).update({name: value})


# What takes each away, before the first kernel is declared.
TRICKS: Final[dict[str, Callable[[], None]]] = {
    **{
        name: _reference(name)
        for name in (
            "page_sum",
            "page_product",
            "page_within",
            "line_product",
            "line_products",
            "weighted_sums",
            "spread_product",
            "variance_product",
            "lowest_bit",
        )
    },
    "part (with counting)": _numpy_views,
    "no counting of references": _replace(decorators, "entry_options", _counting),
    "copied into callers": _replace(decorators, "inner_options", _called),
    "inner kernels without code": _replace(decorators, "inner_options", _finished),
    "called by name": _replace(linked, "callable_by_name", lambda _name, kernel, _signature: kernel),
    "other processes": _replace(precompile, "is_possible", lambda _cache: False),
}


def main() -> int:
    """Measure each trick, print, and return 1 if a result depends on one."""
    parser = argparse.ArgumentParser(
        prog="python -m checks.speed.tricks", description="What each trick gains."
    )
    parser.add_argument("names", metavar="NAME", nargs="*", help=f"of {', '.join(TRICKS)}; default all")
    parser.add_argument("--without", metavar="NAME", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.without:
        print(json.dumps(_measured(given.without)))
        return 0
    unknown = [name for name in given.names if name not in TRICKS]
    if unknown:
        parser.error(f"no trick is called {unknown[0]!r}; there are {', '.join(TRICKS)}")
    whole = _in_process(ALL)
    print(f"{'without':28}" + "".join(f"{name:>22}" for name in whole if name != "events"))
    _print(ALL, whole, whole)
    same = True
    for name in given.names or TRICKS:
        found = _in_process(name)
        _print(name, found, whole)
        if found["events"] != whole["events"]:
            print(f"  other events without {name}", file=sys.stderr)
            same = False
    return 0 if same else 1


def _print(name: str, found: dict[str, Any], whole: dict[str, Any]) -> None:
    cells = [
        f"{value:.4g} ({value / whole[column] - 1:+.0%})"
        for column, value in found.items()
        if column != "events"
    ]
    print(f"{name:28}" + "".join(f"{cell:>22}" for cell in cells), flush=True)


def _in_process(name: str) -> dict[str, Any]:
    command = [sys.executable, "-m", "checks.speed.tricks", "--without", name]
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603 - our own interpreter
    if done.returncode:
        raise SystemExit(f"without {name}: {done.stderr.strip().splitlines()[-1]}")
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def _measured(without: str) -> dict[str, Any]:
    """Return what compiling takes and what frames take, and a digest of the events, without one trick."""
    if without != ALL:
        TRICKS[without]()
    with tempfile.TemporaryDirectory(prefix="mossar-tricks-") as folder:
        vars(cache)["make_folder"] = lambda _parents, _name: cache.Cache(Path(folder), lasts=True)
        return _compiled_and_run()


def _compiled_and_run() -> dict[str, Any]:
    import mossar_stream
    from mossar_tools.bench.motion import performer

    began = time.perf_counter()
    mossar_stream.precompile()
    compiled = time.perf_counter() - began
    motion = performer(SECONDS)
    found: dict[str, Any] = {"compile s": compiled}
    digest = hashlib.sha256()
    for name, settings in (
        ("motion ns/frame", mossar_stream.Settings()),
        ("posture ns/frame", mossar_stream.Settings(level="posture")),
        ("path kernel ns/frame", mossar_stream.Settings.build("paper", {})),
    ):
        took = []
        for _ in range(RUNS):
            segmenter = mossar_stream.Segmenter(motion.skeleton, settings, fps=motion.fps)
            events = []
            start = time.process_time()
            for i in range(0, len(motion.times), CHUNK):
                events += segmenter.push(motion.positions[i : i + CHUNK], motion.times[i : i + CHUNK])
            took.append(time.process_time() - start)
        digest.update(repr(events).encode())
        found[name] = min(took[1:]) * 1e9 / len(motion.times)
    frames = [(motion.positions[i], float(motion.times[i])) for i in range(len(motion.times))]
    segmenter = mossar_stream.Segmenter(motion.skeleton, fps=motion.fps)
    single = []
    for frame, when in frames:
        start = time.perf_counter()
        segmenter.push(frame, when)
        single.append(time.perf_counter() - start)
    return {**found, "one frame, ns": statistics.median(single) * 1e9, "events": digest.hexdigest()}


if __name__ == "__main__":
    sys.exit(main())
