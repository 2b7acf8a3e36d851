"""People panel: the person of each slot, with buttons that pin and exchange them."""

from collections.abc import Callable
from html import escape
from typing import Any

from viser import GuiApi

from mossar_adapters.people.source import shown
from mossar_tools.dashboard.live import LiveShow

_PIN, _UNPIN = "Pin", "Unpin"


class PeoplePanel:
    """The widgets.

    Args:
        gui: Where they go.
        show: Whose people.
        on: Has something done when a person touches a widget.
    """

    def __init__(self, gui: GuiApi, show: LiveShow, on: Callable[[Any, Callable[[Any], None]], None]) -> None:
        self._show = show
        self._table = gui.add_html("")
        self._slots: tuple[str, ...] = ("p1",)
        self._one: Any = gui.add_dropdown("slot", self._slots, hint="Which slot to pin or exchange")
        self._other: Any = gui.add_dropdown("with", self._slots, hint="Whose slot it gets")
        pins = gui.add_button_group(
            "", (_PIN, _UNPIN), hint="Keep the slot for its person, however long it is away"
        )
        on(pins, lambda value: show.pin(self._one.value, pinned=value == _PIN))
        exchange = gui.add_button("Exchange", hint="The two get each other's slots; their takes end")
        on(exchange, lambda _: show.exchange(self._one.value, self._other.value))

    def sync(self) -> None:
        """Show the present person of each slot."""
        rows = self._show.people
        slots = tuple(str(row["slot"]) for row in rows) or ("p1",)
        if slots != self._slots:
            self._slots = slots
            self._one.options = self._other.options = slots
            self._other.value = slots[min(1, len(slots) - 1)]
        content = people_card(rows)
        if self._table.content != content:
            self._table.content = content


def people_card(rows: list[dict[str, object]]) -> str:
    """Return the slots as HTML."""
    lines = [
        f"{escape(str(row['slot']))}: {escape(shown(str(row['id'])))}"
        f"{'' if row['there'] else ', away'}{', pinned' if row['pinned'] else ''}"
        for row in rows
    ]
    return f'<div class="mossar m-card" id="mossar-people">{"<br>".join(lines) or "nobody yet"}</div>'
