"""Machine: where the numbers come from, and the load of other programs meanwhile."""

import os
import platform
import time
from pathlib import Path

import msgspec
import msgspec.structs
import numpy as np

import mossar_stream

_QUIET_CORES = 0.15  # cores that others may use on a machine that counts as idle
_QUIET_LOAD = 0.5  # load average, likewise, where the system does not report the load of other programs
_STAT, _INFO = Path("/proc/stat"), Path("/proc/cpuinfo")
_IDLE = (3, 4)  # fields of /proc/stat's first line: idle and waiting for a disk
_STOLEN = 7


class Machine(msgspec.Struct, frozen=True):
    """The machine of a measurement.

    Args:
        cpu: Name of the processor.
        cores: That this process may use.
        system: Operating system.
        versions: Of Python and of the libraries.
        load: Load average over a minute, before and after; None where the system has none.
        others: Cores that other processes used on average meanwhile; None where the system does not report it.
        stolen: Cores that the host of a virtual machine took away meanwhile.
    """

    cpu: str
    cores: int
    system: str
    versions: dict[str, str]
    load: tuple[float, float] | None = None
    others: float | None = None
    stolen: float | None = None

    @property
    def busy(self) -> bool:
        """Whether neighbours loaded the machine."""
        if self.others is None:
            return self.load is not None and self.load[0] > _QUIET_LOAD
        return self.others + (self.stolen or 0.0) > _QUIET_CORES


class Watch:
    """Looks at the machine from now on."""

    def __init__(self) -> None:
        self._load = _load()
        self._began = time.monotonic()
        self._before = _seconds()
        self._own = _own_seconds()

    def machine(self) -> Machine:
        """Return the machine and its load since the beginning."""
        found = Machine(
            _cpu(),
            _cores(),
            f"{platform.system()} {platform.release()}",
            {
                "mossar-stream": mossar_stream.__version__,
                "python": platform.python_version(),
                "numpy": np.__version__,
            },
        )
        load, now = _load(), _seconds()
        if self._load is not None and load is not None:
            found = msgspec.structs.replace(found, load=(self._load, load))
        elapsed = time.monotonic() - self._began
        if self._before is None or now is None or elapsed <= 0.0:
            return found
        busy, stolen = (b - a for a, b in zip(self._before, now, strict=True))
        others = max(0.0, busy - stolen - (_own_seconds() - self._own))
        return msgspec.structs.replace(found, others=others / elapsed, stolen=stolen / elapsed)


def _load() -> float | None:
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def _own_seconds() -> float:
    """Return the processor time of this process and of its children that have ended, s."""
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


def _seconds() -> tuple[float, float] | None:
    """Return the seconds that all cores have worked, and those stolen from them, since the start."""
    if not _STAT.is_file():
        return None
    ticks = [int(field) for field in _STAT.read_text().split("\n", 1)[0].split()[1:9]]
    per_second = os.sysconf("SC_CLK_TCK")
    busy = sum(count for place, count in enumerate(ticks) if place not in _IDLE)
    return busy / per_second, ticks[_STOLEN] / per_second


def _cpu() -> str:
    if _INFO.is_file():
        for line in _INFO.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
