"""Values: from the text of an option to its value."""

import argparse
import math
from typing import Literal

from mossar_adapters.people.given import MOST


def setting(text: str) -> tuple[str, str]:
    """Return name and value of `name=value`."""
    name, equals, value = text.partition("=")
    if not equals or not name.strip():
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not of the form name=value")
    return name.strip(), value.strip()


def names(text: str) -> tuple[str, ...]:
    """Return the parts between commas."""
    parts = tuple(part.strip() for part in text.split(",") if part.strip())
    if not parts:
        raise argparse.ArgumentTypeError("there is no name in it")
    return parts


def tolerances(text: str) -> tuple[float, ...]:
    """Return positive numbers between commas, in their order."""
    return tuple(sorted({positive(part) for part in names(text)}))


def factors(text: str) -> tuple[float, ...]:
    """Return numbers from 0.1 to 10 between commas, each once, in their order."""
    given = tuple(dict.fromkeys(positive(part) for part in names(text)))
    for factor in given:
        if not 0.1 <= factor <= 10.0:
            raise argparse.ArgumentTypeError(f"{factor:g} is not a factor from 0.1 to 10")
    return given


def positive(text: str) -> float:
    """Return a positive number."""
    number = _number(text)
    if not 0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a positive number")
    return number


def share(text: str) -> float:
    """Return a number that is not negative."""
    number = _number(text)
    if not 0 <= number < math.inf:
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a number from 0")
    return number


def seconds(text: str) -> float:
    """Return a time, s: a number, or as a clock shows it, 1:30."""
    number = _of_clock(text) if ":" in text else _number(text)
    if not math.isfinite(number):
        raise argparse.ArgumentTypeError(
            f"{text[:40]!r} is not a number of seconds; 90, 1:30 and 0:01:30 are"
        )
    return number


def _of_clock(text: str) -> float:
    """Return the seconds of `minutes:seconds` or `hours:minutes:seconds`; NaN if it is neither."""
    *whole, last = text.split(":")
    if len(whole) > 2 or not all(part.isdecimal() for part in whole) or not 0 <= _number(last) < 60:
        return math.nan
    minutes = 0
    for part in whole:
        minutes = 60 * minutes + int(part)
    return 60.0 * minutes + _number(last)


def inches(text: str) -> float:
    """Return the width of a picture, 4 to 100 inches."""
    number = _number(text)
    if not 4 <= number <= 100:
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a number of inches from 4 to 100")
    return number


def whole(text: str) -> int:
    """Return a whole number from 0."""
    if not text.strip().isdecimal():
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a whole number from 0")
    return int(text)


def count(text: str) -> int:
    """Return a whole number from 1."""
    if not text.strip().isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a whole number from 1")
    return int(text)


def people(text: str) -> int | Literal["nearest", "first"]:
    """Return the number of people, or the choice of one."""
    match text.strip():
        case "nearest":
            return "nearest"
        case "first":
            return "first"
        case number if number.isdecimal() and 1 <= int(number) <= MOST:
            return int(number)
    raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a number from 1 to {MOST}, nearest or first")


def port(text: str) -> int:
    """Return a port number; 0 stands for any free one."""
    if not (number := text.strip()).isdecimal() or int(number) > 65535:
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a port from 0 to 65535")
    return int(number)


def run_id(text: str) -> str:
    """Return the name of a run: 1 to 64 characters that print, without spaces."""
    if not 1 <= len(text) <= 64 or not text.isprintable() or " " in text:
        raise argparse.ArgumentTypeError("a run is called by 1 to 64 characters without spaces")
    return text


def place(text: str) -> tuple[str, int]:
    """Return host and port of `HOST:PORT`; the host of this computer if there is only a port."""
    host, _, number = text.rpartition(":")
    return host.strip("[]") or "127.0.0.1", port(number)


def speed(text: str) -> float | Literal["max"]:
    """Return a positive number or "max"."""
    if text == "max":
        return "max"
    number = _number(text)
    if not 0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is neither a positive number nor max")
    return number


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
