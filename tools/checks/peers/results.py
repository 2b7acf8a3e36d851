"""Results: ours and the peers on the same recordings, and the conclusion."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import msgspec
import numpy as np

from checks.peers import ours, whole_file
from checks.peers.peer import Peer
from checks.peers.runner import PeerRun, run_peer
from checks.peers.table import PEERS
from mossar_adapters.extras import installed
from mossar_stream import MossarError
from mossar_tools.bench.measurement import OWN
from mossar_tools.evaluation.metrics import median
from mossar_tools.evaluation.report import finite
from mossar_tools.evaluation.takes import Take

WORTH = 0.5  # F1 from which a peer's speed is compared with ours
LONG = 5.0  # s of a run that is not repeated
TIMES = 10.0  # target of our speed relative to such a peer
NOTES = """F1: mean over recordings, one-to-one within the label's tolerance; delay: median time from the true cut to the decision
frames/s: from positions to cuts, processor time where marked "cpu"; the input of a peer, the mean joint speed (curve) or
the coordinates relative to the centre (poses), is made in numpy frame by frame; alone: if it came for nothing
p50, p99: for one frame, by the wall clock
settings of peers: the best of a coarse grid for each level, with the truth of the labelled recordings that the documentation
names in sight; ours: its defaults. * knows more than a stream"""


class Result(msgspec.Struct, frozen=True):
    """One line.

    Args:
        name: Of the method.
        group: Of the recordings.
        rates: frames/s of each run, from positions to cuts.
        alone: frames/s, median, of the detector itself, without the cost of its input.
        clock: Clock of these rates.
        f1: Mean over the recordings.
        delay: s, median; NaN where there is none.
        p50: us for one frame; NaN where frames do not come one by one.
        p99: us.
        settings: In words.
        knows: More than a stream does, or empty.
    """

    name: str
    group: str
    rates: tuple[float, ...]
    alone: float
    clock: str
    f1: float
    delay: float
    p50: float
    p99: float
    settings: str
    knows: str = ""

    @property
    def rate(self) -> float:
        """The median."""
        return float(np.median(self.rates))


def usable_peers() -> tuple[list[Peer], list[str]]:
    """Return the peers that are installed, and a note for each that is not.

    Raises:
        MossarError: If none is.
    """
    there = [peer for peer in PEERS if installed(peer.library)]
    if not there:
        raise MossarError(
            "python -m checks.peers needs an extra, best in an environment of its own: pip install 'mossar-stream[peers]'"
        )
    missing = dict.fromkeys(peer.distribution for peer in PEERS if peer not in there)
    return there, [f"{name} is not installed and left out (pip install {name})" for name in missing]


def compare(
    groups: Mapping[str, list[Take]], peers: Sequence[Peer], repeats: int, on_progress: Callable[[str], None]
) -> Iterator[Result]:
    """Yield the results, group by group.

    Args:
        groups: Takes by group.
        peers: The other libraries.
        repeats: Runs, at most; one that takes long is not repeated.
        on_progress: Gets the present task.
    """
    for group, takes in groups.items():
        on_progress(f"peers: {ours.NAME}, {group}")
        yield _result(f"{ours.NAME}, frame by frame", group, partial(ours.one_by_one, takes), repeats)
        yield _result(f"{ours.NAME}, chunks of 64", group, partial(ours.in_chunks, takes), repeats)
        for peer in peers:
            on_progress(f"peers: {peer.name}, {group}")
            chosen = peer.best[takes[0].level]
            words = ", ".join([f"fed {peer.feed}", *(f"{k}={_short(v)}" for k, v in chosen.items())])
            run = partial(run_peer, takes, peer, chosen)
            yield _result(peer.name, group, run, repeats, words)
        if installed("ruptures"):
            run = partial(whole_file.told_the_number, takes)
            yield _result(whole_file.NAME, group, run, repeats, "fed poses", whole_file.KNOWS)


def _result(
    name: str,
    group: str,
    run: Callable[[], PeerRun],
    repeats: int,
    settings: str = "defaults",
    knows: str = "",
) -> Result:
    """Run once to compile and warm up, then for the record."""
    first = run()
    runs = [run() for _ in range(repeats)] if first.wall < LONG else [first]
    shares = [own.cpu / own.wall for own in runs]
    by_cpu = bool(np.median(shares) < OWN)
    last = runs[-1]
    p50, p99 = (float(np.quantile(last.waits, share)) * 1e6 for share in (0.5, 0.99))
    return Result(
        name,
        group,
        tuple(own.frames / (own.cpu if by_cpu else own.wall) for own in runs),
        float(
            np.median(
                [
                    own.frames / own.alone / (share if by_cpu else 1.0)
                    for own, share in zip(runs, shares, strict=True)
                ]
            )
        ),
        "cpu" if by_cpu else "wall",
        last.scores.f1,
        median(last.scores.delays),
        p50,
        p99,
        settings,
        knows,
    )


def result_lines(rows: Sequence[Result]) -> Iterator[str]:
    """Yield a table for each group, and its conclusion."""
    for group in dict.fromkeys(row.group for row in rows):
        own = [row for row in rows if row.group == group]
        yield f"{'method, ' + group:<36}{'F1':>6}{'delay':>9}{'frames/s':>12}{'alone':>12} {'clock':<5}{'p50':>12}{'p99':>12}  settings"
        for row in sorted(own, key=lambda one: -one.f1):
            mark = "*" if row.knows else ""
            more = f"; knows {row.knows}" if row.knows else ""
            yield (
                f"{row.name + mark:<36}{row.f1:>6.2f}{_unit(row.delay, '.2f', 's'):>9}{row.rate:>12,.0f}{row.alone:>12,.0f} {row.clock:<5}"
                f"{_unit(row.p50, ',.1f', 'us'):>12}{_unit(row.p99, ',.1f', 'us'):>12}  {row.settings}{more}"
            )
        yield from conclusions(own)
        yield ""


def conclusions(rows: Sequence[Result]) -> Iterator[str]:
    """Yield whether we are ahead in one group."""
    mine = [row for row in rows if row.name.startswith(ours.NAME)]
    others = [row for row in rows if row not in mine and not row.knows]
    if not mine or not others:
        return
    best = max(others, key=lambda row: row.f1)
    f1 = mine[0].f1
    yield f"F1 {f1:.2f}, the best peer {best.f1:.2f} ({best.name}): {'ahead' if f1 > best.f1 else 'NOT ahead'}"
    worthy = [row for row in others if row.f1 >= WORTH]
    for own in mine:
        for row in worthy:
            ratio = own.rate / row.rate
            verdict = "met" if ratio >= TIMES else "missed"
            yield f"{own.name}: {ratio:,.1f} times the throughput of {row.name} (>= {TIMES:g}: {verdict})"
    if not worthy:
        yield f"no peer reaches F1 {WORTH:g}"


def results_json(rows: Sequence[Result]) -> list[dict[str, Any]]:
    """Return everything for programs; missing values are None."""
    return [
        {
            "name": row.name,
            "group": row.group,
            "frames_per_s": row.rate,
            "frames_per_s_alone": row.alone,
            "runs": row.rates,
            "clock": row.clock,
            "f1": row.f1,
            "delay_s": finite(row.delay),
            "p50_us": finite(row.p50),
            "p99_us": finite(row.p99),
            "settings": row.settings,
            "knows": row.knows,
        }
        for row in rows
    ]


def _unit(value: float, form: str, unit: str) -> str:
    return f"{value:{form}} {unit}" if np.isfinite(value) else "-"


def _short(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
