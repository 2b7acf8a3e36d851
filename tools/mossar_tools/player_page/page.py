"""Page for players and clients: collects the state to show, and carries out requests of its windows."""

import json
import math
import threading
import time
import webbrowser
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final

from mossar_adapters.newest import Newest
from mossar_tools.dashboard.glimpse import Glimpse
from mossar_tools.dashboard.live import MOST_PERFORMERS, LiveShow
from mossar_tools.dashboard.rounds import Rounds
from mossar_tools.dashboard.tasks import Tasks
from mossar_tools.dashboard.teaching import mark_of
from mossar_tools.dashboard.teaching_view import MOST, drawing, seconds_of_example
from mossar_tools.player_page.pictures import CAMERA, jpeg_of, people_in, with_text
from mossar_tools.player_page.server import Asked, PlayerServer
from mossar_tools.player_page.state import State, state_of
from mossar_tools.player_page.verdicts import Judge

if TYPE_CHECKING:
    from mossar_adapters.pose.source import Seen

RATE: Final = 25.0  # Hz
_STALE: Final = 1.5  # s without frames after which the page shows it
_SLOW: Final = 12.0  # pictures a second; fewer lose fast movements
_SLOW_FOR: Final = 3.0  # s, before the page shows it
_STANDS: Final = 10.0  # s for which a warning stays as it is
Preview = Callable[[], "Seen | None"]


class _Performer:
    """The memory of the page of a performer."""

    def __init__(self, now: float) -> None:
        self.judge = Judge()
        self.began = now  # monotonic s
        self.reached = -1.0  # s of the stream
        self.heard = now  # monotonic s, when that came
        self.slow_since: float | None = None  # monotonic s


class PlayerPage:
    """Shows a live show in the windows of a server until it is closed.

    Args:
        server: To be attached.
        show: The show to draw.
        preview: Returns the latest picture of a camera of this computer; None if there is none.
        model: Of the networks that estimate the camera's pictures; empty if there is none.
        open_dashboard: Opens the dashboard and returns its port; None if there is none.
    """

    def __init__(
        self,
        server: PlayerServer,
        show: LiveShow,
        *,
        preview: Preview | None = None,
        model: str = "",
        open_dashboard: Callable[[], int] | None = None,
    ) -> None:
        self._server, self._show = server, show
        self._preview, self._model = preview, model
        self._note = ""  # error of the last request
        self._tasks = Tasks(self._fail)
        self._performers: Newest[str, _Performer] = Newest(MOST_PERFORMERS)
        self._seen: Seen | None = None  # whose picture is at hand
        self._seen_at = 0.0  # monotonic s, when that came
        self._picture = b""
        self._people: list[Any] = []
        self._warning, self._warned_at = "", -math.inf  # of few pictures; monotonic s
        self._moves, self._changes = show.teaching.moves, 0
        self._rounds = Rounds(self._draw, RATE, "page")
        server.attach(self._hear, self._examples, open_dashboard)

    def start(self, *, open_browser: bool) -> None:
        """Begin to draw.

        Args:
            open_browser: Whether to open a browser as well.
        """
        self._rounds.start()
        if open_browser:
            threading.Thread(target=webbrowser.open, args=(self._server.url,), daemon=True).start()

    def close(self) -> None:
        """Stop drawing. May be called twice."""
        self._rounds.close()
        self._tasks.close()

    def _hear(self, asked: Asked) -> None:
        """Carry out a request of a window, after all earlier ones."""
        teaching = self._show.teaching
        wanted: dict[str, Callable[[], None]] = {
            "teach": lambda: self._show.teach(asked.name.strip()),
            "cancel": teaching.cancel,
            "keep": teaching.keep,
            "undo": teaching.undo,
            "forget": lambda: teaching.forget(asked.place, asked.mark),
            "again": self._begin_again,
        }
        if asked.do in wanted:
            self._note = ""
            self._tasks.ask(wanted[asked.do])

    def _begin_again(self) -> None:
        """Count from 0, and start the clock anew."""
        self._show.count_again()
        self._performers.clear()

    def _fail(self, why: str) -> None:
        self._note = why

    def _draw(self, _: int) -> None:
        glimpses = self._show.glimpses()  # also without a window, so that waiting frames are processed
        now = time.monotonic()
        states = [self._state(glimpse, now) for glimpse in glimpses]
        if not self._server.windows:
            return
        seen = self._preview() if self._preview is not None else None
        if seen is not None and seen is not self._seen:
            self._seen, self._picture, self._people = seen, jpeg_of(seen), people_in(seen)
            self._seen_at = now
        state: State = {
            "performers": states,
            "teaching": self._teaching(),
            "note": self._note or self._trouble(glimpses, now),
        }
        text = json.dumps(state)
        if seen is None:
            self._server.spread(text)
            return
        here = json.dumps({**state, "people": self._people, "outline": CAMERA})
        self._server.spread(text, with_text(self._picture, here.encode()))

    def _state(self, glimpse: Glimpse, now: float) -> State:
        known = self._performers.get(glimpse.performer)
        if known is None:
            known = self._performers[glimpse.performer] = _Performer(now)
        if glimpse.now != known.reached:
            known.reached, known.heard = glimpse.now, now
        state = state_of(glimpse, known.judge, now - known.began)
        state["stale"] = now - known.heard > _STALE
        rate = self._show.rate_of(glimpse.performer)
        is_slow = rate is not None and 0 < rate < _SLOW and not state["stale"]
        known.slow_since = (known.slow_since or now) if is_slow else None
        state["rate"] = None if rate is None else round(rate)
        return state

    def _trouble(self, glimpses: Sequence[Glimpse], now: float) -> str:
        """Return the reason why the page has nothing to show, and the remedy; empty if there is none."""
        if not glimpses:
            return self._show.waits_for
        shown = [known for glimpse in glimpses if (known := self._performers.get(glimpse.performer))]
        if all(now - known.heard > _STALE for known in shown):
            return self._absence(now)
        if now - self._warned_at > _STANDS:
            self._warning = ""
            slow = [known.slow_since for known in shown if known.slow_since is not None]
            if self._model and self._model != "lite" and slow and now - min(slow) > _SLOW_FOR:
                rate = min(self._show.rate_of(glimpse.performer) or 0.0 for glimpse in glimpses)
                self._warning = (
                    f"only {rate:.0f} pictures a second: the model lite is faster (webcam:?model=lite)"
                )
                self._warned_at = now
        return self._warning

    def _absence(self, now: float) -> str:
        """Return the reason, if known, why no person is seen any more."""
        if not self._model:
            return "no frames come"
        if self._seen is not None and now - self._seen_at > _STALE:
            return "the camera gives no more pictures"
        return "step back until the whole body is in the picture"

    def _teaching(self) -> State:
        teaching = self._show.teaching
        state = teaching.state
        return {
            "phase": state.phase,
            "runs": state.runs,
            "keep": state.can_keep,
            "undo": state.can_undo,
            "name": state.name,
            "seconds": state.seconds,
            "message": state.message,
            "first": self._show.first_name,
            "version": self._version(),
        }

    def _version(self) -> int:
        """Return a number that changes with the examples."""
        moves = self._show.teaching.moves
        if moves is not self._moves:  # teaching makes new ones with each change
            self._moves, self._changes = moves, self._changes + 1
        return self._changes

    def _examples(self) -> bytes:
        """Return the taught examples, the last ones, as JSON."""
        moves = self._show.teaching.moves
        shown = [] if moves is None else list(enumerate(moves.examples))[-MOST:]
        return json.dumps(
            [
                {
                    "name": example.name,
                    "place": place,
                    "mark": mark_of(example),
                    "seconds": round(seconds_of_example(example, moves.skeleton), 2),
                    "drawing": drawing(example, moves.skeleton),
                }
                for place, example in shown
                if moves is not None
            ]
        ).encode()
