"""Teaching panel: name, button and examples among the controls of a live page."""

from collections.abc import Callable
from typing import Any

from viser import GuiApi, Icon

from mossar_tools.dashboard.live import LiveShow
from mossar_tools.dashboard.teaching_view import countdown, examples_card


class TeachingPanel:
    """The widgets.

    Args:
        gui: The page's widgets.
        show: The show that is taught.
        on: Registers a task for the touch of a widget.
    """

    def __init__(self, gui: GuiApi, show: LiveShow, on: Callable[[Any, Callable[[Any], None]], None]) -> None:
        self._show = show
        self._name = gui.add_text(
            "name", show.first_name, hint="Of the move; several examples may have the same"
        )
        hint = "Counts down from three, then takes one movement from rest to rest"
        self._button = gui.add_button("Teach", icon=Icon.SCHOOL, hint=hint)
        on(self._button, lambda _: self._switch())
        hint = "Keeps the last movement although it is unlike the others of its name"
        self._keep = gui.add_button("Keep", icon=Icon.CHECK, hint=hint, visible=False)
        on(self._keep, lambda _: show.teaching.keep())
        hint = "Takes back the last example of the file"
        self._undo = gui.add_button("Undo", icon=Icon.ARROW_BACK_UP, hint=hint, visible=False)
        on(self._undo, lambda _: show.teaching.undo())
        self._examples, self._count = gui.add_html(""), gui.add_html("")

    def sync(self) -> None:
        """Show the progress of teaching, and the examples."""
        teaching = self._show.teaching
        state = teaching.state
        card = examples_card(teaching.moves, state.message)
        for handle, content in ((self._count, countdown(state)), (self._examples, card)):
            if handle.content != content:
                handle.content = content
        for button, visible in ((self._keep, state.can_keep), (self._undo, state.can_undo)):
            if button.visible != visible:
                button.visible = visible
        word = "Cancel" if state.runs else "Teach"
        if self._button.label != word:
            self._button.label = word

    def _switch(self) -> None:
        if self._show.teaching.state.runs:
            self._show.teaching.cancel()
        else:
            self._show.teach(self._name.value.strip())

    def forget(self, asked: str) -> Callable[[], None]:
        """Return a function that forgets an example.

        Args:
            asked: Place and mark of the example, as in `3-1f00ba12`.

        Raises:
            ValueError: If it is no such text.
        """
        place, _, mark = asked.partition("-")
        number = int(place)
        return lambda: self._show.teaching.forget(number, mark)
