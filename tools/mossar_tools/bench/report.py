"""Report: the table for people, and one JSON object for programs."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from mossar_tools.bench.machine import Machine
from mossar_tools.bench.measurement import OWN, Measurement, Unit

NOTES = f"""medians of repeated runs [least .. largest]; "wall" is time by the wall clock, "cpu" processor time, which is shown where
a run had the processor for less than {OWN:.0%} of the time"""
BUSY = """Neighbours loaded the machine: caches and memory are shared with them, so that even processor times are longer than on
an idle machine. "half (busy)": half of the target, which is acceptable then."""
_SCALES = ((1e9, "G"), (1e6, "M"), (1e3, "k"))


def machine_lines(machine: Machine) -> Iterator[str]:
    """Yield the machine of the measurements, and whether it was idle."""
    versions = ", ".join(f"{name} {version}" for name, version in machine.versions.items())
    yield f"{machine.cpu}, {machine.cores} cores; {machine.system}; {versions}"
    if machine.load is not None:
        line = f"load average {machine.load[0]:.1f} before, {machine.load[1]:.1f} after"
        if machine.others is not None:
            line += f"; other processes used {machine.others:.2f} cores"
        if machine.stolen:
            line += f", the host took {machine.stolen:.2f}"
        yield line
    yield from (BUSY if machine.busy else "No neighbour loaded the machine.").splitlines()


def part_lines(title: str, rows: Sequence[Measurement], *, busy: bool) -> Iterator[str]:
    """Yield the table of one part."""
    yield title
    width = max(52, *(len(row.name) for row in rows))
    for row in rows:
        least, most = (_number(found(row.values), row.unit) for found in (min, max))
        spread = f"[{least} .. {most}]" if len(row.values) > 1 else ""
        line = f"  {row.name:<{width}} {_number(row.value, row.unit):>9} {row.unit:<10}  {spread:<20} {row.clock:<5}"
        if row.target is not None:
            sign = ">=" if row.target.at_least else "<="
            line += f" {sign} {_number(row.target.limit, row.unit):<7} {row.target.verdict(row.value, busy=busy):<12}"
        yield f"{line} {row.note}".rstrip()


def as_json(machine: Machine, rows: Sequence[Measurement]) -> dict[str, Any]:
    """Return everything that was measured."""
    return {
        "v": 1,
        "machine": machine,
        "busy": machine.busy,
        "measurements": [_row(row, busy=machine.busy) for row in rows],
    }


def table(rows: Sequence[Measurement]) -> list[dict[str, Any]]:
    """Return a flat row for each measurement, for spreadsheets."""
    return [
        {
            **_common(row),
            "clock": row.clock,
            "target": row.target.limit if row.target else None,
            "note": row.note,
        }
        for row in rows
    ]


def _common(row: Measurement) -> dict[str, Any]:
    values = {"median": row.value, "min": min(row.values), "max": max(row.values)}
    return {"part": row.part, "name": row.name, "unit": row.unit, **values}


def _row(row: Measurement, *, busy: bool) -> dict[str, Any]:
    target = None
    if row.target is not None:
        verdict = row.target.verdict(row.value, busy=busy)
        target = {"limit": row.target.limit, "at_least": row.target.at_least, "verdict": verdict}
    times = {"shown": row.clock, "wall": row.wall, "cpu": row.cpu}
    return {**_common(row), **times, "target": target, "note": row.note}


def _number(value: float, unit: Unit) -> str:
    """Return three digits, of rates with a letter for thousands and more."""
    for scale, letter in _SCALES:
        if unit == "frames/s" and abs(value) >= scale * 0.9995:
            return f"{_digits(value / scale)} {letter}"
    return _digits(value)


def _digits(value: float) -> str:
    if value == 0.0:
        return "0"
    places = max(0, 2 - int(np.floor(np.log10(abs(value)))))
    return f"{value:,.{min(places, 4)}f}"
