"""Palette: colours of pictures and dashboards, distinct with any kind of colour vision (Okabe and Ito)."""

from typing import Final

import msgspec


class Palette(msgspec.Struct, frozen=True):
    """Colours by their meaning, as `#rrggbb`."""

    background: str
    ink: str
    muted: str
    faint: str
    moving: str
    resting: str
    onset: str
    offset: str
    minimum: str
    left: str
    right: str
    level: str
    truth: str


LIGHT: Final = Palette(
    background="#ffffff",
    ink="#1f2430",
    muted="#6b7280",
    faint="#d9dde3",
    moving="#e69f00",
    resting="#94b8d3",
    onset="#009e73",
    offset="#cc79a7",
    minimum="#0072b2",
    left="#0072b2",
    right="#d55e00",
    level="#d55e00",
    truth="#1f2430",
)
DARK: Final = Palette(
    background="#14171f",
    ink="#e8eaf0",
    muted="#9aa2b1",
    faint="#363d4c",
    moving="#e69f00",
    resting="#3f6079",
    onset="#2fc79b",
    offset="#e39ac4",
    minimum="#56b4e9",
    left="#56b4e9",
    right="#f0813a",
    level="#f0813a",
    truth="#e8eaf0",
)


def palette(*, dark: bool) -> Palette:
    """Return the colours for dark pages, or for light ones."""
    return DARK if dark else LIGHT
