"""Page: the server, and the thread that draws."""

import math
import sys
import threading
import webbrowser
from collections.abc import Callable
from html import escape
from pathlib import Path

import numpy as np

from mossar_adapters.extras import needed
from mossar_tools.console import LOGGER
from mossar_tools.dashboard.camera_picture import WIDTH, camera_picture
from mossar_tools.dashboard.chart import chart
from mossar_tools.dashboard.framing import size_teller
from mossar_tools.dashboard.glimpse import Glimpse
from mossar_tools.dashboard.live import LiveShow
from mossar_tools.dashboard.overview import overview, place
from mossar_tools.dashboard.recorded import RecordedShow
from mossar_tools.dashboard.rings import rings
from mossar_tools.dashboard.rounds import Rounds
from mossar_tools.dashboard.style import PANEL, sheet
from mossar_tools.dashboard.tables import WAITING, facts_card, marks_card, state_card
from mossar_tools.dashboard.visitors import HERE, Visitors
from mossar_tools.palette import DARK, LIGHT

PORT = 8080
RATE = 30.0  # Hz, of the scene
_CHART_EVERY = 2  # rounds
_TABLES_EVERY = 8
_BRAND = (0, 78, 122)  # becomes the palette's blue where viser paints buttons with it
_NO_PICTURE = np.zeros((180, WIDTH, 3), np.uint8)  # until the camera gives one
_SWITCH = 0.001  # s after which a thread that computes lets another one go on


class Page:
    """Serves the dashboard and draws into it until it is closed.

    Args:
        show: The show to draw.
        port: Where; the next free one if it is in use, 0 for any.
        dark: Whether to begin in dark.
        folder: Where files of the buttons are written.
        host: Address of this computer where it listens; other devices then need a URL that serves once.
        visitors: Devices that another page of this program lets in; None for this page's own.

    Raises:
        MossarError: If viser is not installed.
    """

    def __init__(
        self,
        show: LiveShow | RecordedShow,
        port: int = PORT,
        *,
        dark: bool = False,
        folder: Path | None = None,
        host: str = HERE,
        visitors: Visitors | None = None,
    ) -> None:
        needed("viser", "view", "the dashboard")
        import rich

        from mossar_tools.dashboard.controls import Controls
        from mossar_tools.dashboard.scene import Scene
        from mossar_tools.dashboard.server import open_server

        rich.get_console().quiet = True  # viser announces itself on standard output, which is ours
        self._show = show
        self._seeks = isinstance(show, RecordedShow)
        answers = {**_answers(show), "mossar/window": self._know_window, "mossar/forget": self._forget}
        self._invites = visitors is None
        self._visitors = visitors or Visitors(host, _tell_invitation)
        self._server = open_server(host, port, answers, self._visitors)
        self.port = self._server.get_port()
        if port not in (0, self.port):
            LOGGER.info("port %d is in use; the dashboard took %d", port, self.port)
        gui = self._server.gui
        gui.add_html(sheet())
        gui.add_html(size_teller())
        gui.set_panel_label("mossar")
        gui.main_panel.dock_right()
        gui.main_panel.set_width(PANEL)
        self._chart = gui.add_html(chart([], seeks=self._seeks))
        self._whole, self._place = gui.add_html(""), gui.add_html("")
        self._drawn = -1  # version of the whole recording
        self._rings = gui.add_html("")
        # At the top of the panel, where all of it is in view.
        self._pictures = [
            (preview, gui.add_image(_NO_PICTURE, label="camera", format="jpeg"))
            for preview in getattr(show, "previews", ())
        ]
        self._state = gui.add_html("")
        self._controls = Controls(self._server, show, folder or Path.cwd())
        self._dark = gui.add_checkbox("dark", dark)
        self._dark.on_update(lambda _: self._paint())
        self._note = gui.add_html("")
        with gui.add_folder("Last key frames"):
            self._marks = gui.add_html("")
        with gui.add_folder("Statistics"):
            self._facts = gui.add_html("")
        visit = show.visit if isinstance(show, RecordedShow) else None
        self._scene = Scene(self._server, DARK if dark else LIGHT, visit)
        self._paint()
        self._rounds = Rounds(self._draw, RATE, "dashboard")

    @property
    def url(self) -> str:
        """URL of the page."""
        return f"http://127.0.0.1:{self.port}"

    @property
    def viewers(self) -> int:
        """Number of windows that show the page."""
        return len(self._server.get_clients())

    def start(self, *, open_browser: bool) -> None:
        """Begin to draw.

        Args:
            open_browser: Whether to open a browser as well.
        """
        sys.setswitchinterval(_SWITCH)
        self._rounds.start()
        LOGGER.info("dashboard: %s", self.url)
        if self._invites and self._visitors.admits_others:
            _tell_invitation(self._visitors.invitation(self.port))
        if open_browser:
            threading.Thread(target=webbrowser.open, args=(self.url,), daemon=True).start()

    def close(self) -> None:
        """Stop drawing and serving."""
        self._rounds.close()
        self._controls.close()
        self._server.stop()

    def _know_window(self, text: str) -> None:
        """Note the size of a window, as in 390x844."""
        across, _, down = text.partition("x")
        self._scene.know_window((int(across), int(down)))

    def _forget(self, text: str) -> None:
        self._controls.forget(text)

    def _paint(self) -> None:
        palette = DARK if self._dark.value else LIGHT
        self._controls.dark = self._dark.value
        self._server.gui.configure_theme(
            dark_mode=self._dark.value, show_logo=False, show_share_button=False, brand_color=_BRAND
        )
        self._scene.paint(palette)

    def _draw(self, rounds: int) -> None:
        glimpses = self._show.glimpses()  # also without a viewer, so that waiting frames are processed
        if not self.viewers:
            return
        with self._server.atomic():
            self._scene.draw(glimpses)
            if rounds % _CHART_EVERY == 0:
                self._chart.content = chart(glimpses, seeks=self._seeks)
                self._draw_whole(glimpses)
                if self._rings.content != (ring := rings(glimpses)):
                    self._rings.content = ring
                if self._controls.teaching is not None:
                    self._controls.teaching.sync()
                for preview, shown in self._pictures:
                    if (seen := preview()) is not None:
                        shown.image = camera_picture(seen)
            if rounds % _TABLES_EVERY == 0:
                self._draw_tables(glimpses)

    def _draw_whole(self, glimpses: list[Glimpse]) -> None:
        show = self._show
        if not isinstance(show, RecordedShow) or not glimpses:
            return
        start, end = show.player.start, show.player.end
        if self._drawn != show.version:
            self._drawn = show.version
            self._whole.content = overview(show.outlines(), start, end)
        self._place.content = place(start, end, (glimpses[0].start, glimpses[0].end), glimpses[0].now)

    def _draw_tables(self, glimpses: list[Glimpse]) -> None:
        recorder = None if isinstance(self._show, RecordedShow) else self._show.recorder
        running = recorder is not None and recorder.running
        self._state.content = state_card(
            glimpses,
            frozen=not isinstance(self._show, RecordedShow) and self._show.frozen,
            recording=recorder.path.name if recorder and running and recorder.path else "",
            frames=recorder.frames if recorder else 0,
            waits_for=WAITING if isinstance(self._show, RecordedShow) else self._show.waits_for,
        )
        self._facts.content = facts_card(glimpses)
        self._marks.content = marks_card(glimpses, seeks=self._seeks)
        note = f'<div class="mossar m-card m-note" id="mossar-note">{escape(self._controls.note)}</div>'
        if self._note.content != note:
            self._note.content = note
        self._controls.sync()


def _tell_invitation(url: str) -> None:
    LOGGER.info("dashboard for one other device, which this URL lets in once: %s", url)


def _answers(show: LiveShow | RecordedShow) -> dict[str, Callable[[str], None]]:
    """Return the requests of the chart."""
    if not isinstance(show, RecordedShow):
        return {}
    return {
        "mossar/seek": lambda value: show.player.seek(_time(value)),
        "mossar/visit": lambda value: show.visit(_time(value)),
    }


def _time(text: str) -> float:
    time = float(text)
    if not math.isfinite(time):
        raise ValueError(text)
    return time
