"""Controls: sliders, buttons and keys, which send requests to the show."""

import time
from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import Any, get_args

from viser import ClientHandle, Icon, ViserServer

from mossar_stream import LEVEL_NAMES, Smoothing
from mossar_tools.console import LOGGER
from mossar_tools.dashboard.exports import key_frames_csv
from mossar_tools.dashboard.levels import highest_strength, level_words, needs_other_bundle
from mossar_tools.dashboard.live import LiveShow
from mossar_tools.dashboard.people_panel import PeoplePanel
from mossar_tools.dashboard.recorded import RecordedShow
from mossar_tools.dashboard.saving import save_settings
from mossar_tools.dashboard.tasks import Tasks
from mossar_tools.dashboard.teaching_panel import TeachingPanel
from mossar_tools.palette import DARK, LIGHT

_ACTIVE = "\N{BLACK CIRCLE} "  # before the name of the level in force
_RESET, _SAVE = "Reset", "Save settings"
_CSV, _PNG = "CSV", "PNG"
SPEEDS = ("0.25", "0.5", "1", "2", "4")
# Names of the keys in browsers; + needs shift on some keyboards and not on others.
_STEPS: Any = (("[plus]", None, 1), ("[plus]", "shift", 1), ("=", None, 1), ("-", None, -1))
_LEVEL_HINT = {
    RecordedShow: "As --level; a level with other features is segmented for again",
    LiveShow: "As --level; a level with other features starts a new take",
}
_QUIET = 0.6  # s after a touch in which the page does not move the touched widget


class Controls:
    """The panel's widgets.

    Args:
        server: The page's server.
        show: The show that they change.
        folder: Folder of written files.
    """

    def __init__(self, server: ViserServer, show: LiveShow | RecordedShow, folder: Path) -> None:
        self._gui = server.gui
        self._show = show
        self._folder = folder
        self._touched: dict[int, float] = {}  # monotonic s at which widgets, by id, were last moved by hand
        self.dark = False  # whether pictures are for dark pages
        self.note = ""  # the last thing that was done or went wrong
        self._tasks = Tasks(self._say)
        with self._gui.add_folder("Level"):
            self._add_level()
        if isinstance(show, RecordedShow):
            with self._gui.add_folder("Playback"):
                self._add_playback(show)
        with self._gui.add_folder("Velocity curve", expand_by_default=True):
            self._add_curve()
        self._add_buttons()
        self.teaching: TeachingPanel | None = None
        if isinstance(show, LiveShow):
            with self._gui.add_folder("Moves"):
                self.teaching = TeachingPanel(self._gui, show, self._on)
        self.people: PeoplePanel | None = None
        if isinstance(show, LiveShow) and show.has_people:
            with self._gui.add_folder("People"):
                self.people = PeoplePanel(self._gui, show, self._on)
        if isinstance(show, RecordedShow):
            self._add_keys(show)

    def sync(self) -> None:
        """Show changes that no person made: the playhead, and sliders that follow one another."""
        show = self._show
        self._set_range(self._level, highest_strength(show.settings))
        self._set(self._level, round(min(show.strength, self._level.max), 2))
        self._say_level()
        self._follow_bundle()
        if self.people is not None:
            self.people.sync()
        if isinstance(show, RecordedShow):
            self._set_range(self._count, max(show.total, 1))
            self._set(self._count, show.kept)
            self._set(self._place, min(max(round(show.player.place, 2), self._place.min), self._place.max))
            word = "Play" if show.player.paused else "Pause"
            if self._pause.label != word:
                self._pause.label = word
                self._pause.icon = Icon.PLAYER_PLAY if show.player.paused else Icon.PLAYER_PAUSE

    def _follow_bundle(self) -> None:
        """Show the settings in force: a level by name may bring others."""
        settings = self._show.settings.resolved()
        self._set(self._threshold, min(max(settings.sig_threshold, 0.0), 0.3))
        self._set(self._window, min(max(settings.window, 0.05), 1.5))
        self._set(self._smoothing, settings.smoothing)
        self._set(self._frames, min(settings.smoothing_window, 60))

    def close(self) -> None:
        """Forget requests that have not begun."""
        self._tasks.close()

    def _set(self, handle: Any, value: float | str) -> None:
        """Move a slider, or choose from a list, unless a person moves it or their request is still to be done."""
        quiet = time.monotonic() - self._touched.get(id(handle), 0.0) > _QUIET
        if handle.value != value and quiet and not self._tasks.waits(id(handle)):
            handle.value = value

    def _set_range(self, slider: Any, highest: float) -> None:
        if slider.max != highest:
            slider.max = highest

    def _say_level(self) -> None:
        show = self._show
        count = show.count if isinstance(show, RecordedShow) else None
        words = escape(level_words(show.settings, show.level, show.strength, count))
        content = f'<div class="mossar m-card m-level" id="mossar-level">{words}</div>'
        if self._words.content != content:
            self._words.content = content
        active = show.level if count is None else None
        labels = tuple(_ACTIVE * (name == active) + name for name in LEVEL_NAMES)
        if self._names.options != labels:
            self._names.options = labels

    def _add_level(self) -> None:
        show = self._show
        self._names = self._gui.add_button_group("level", LEVEL_NAMES, hint=_LEVEL_HINT[type(show)])
        self._on(self._names, lambda label: self._name_level(label.removeprefix(_ACTIVE)))
        top = highest_strength(show.settings)
        self._level = self._gui.add_slider(
            "strength",
            0.0,
            top,
            0.01,
            min(show.strength, top),
            hint="Key frames at least this strong stand. Left: every posture. Right: only the great changes.",
        )
        self._on(self._level, lambda value: show.set_level(float(value)))
        self._words = self._gui.add_html("")
        self._say_level()
        if isinstance(show, RecordedShow):
            self._count = self._gui.add_slider(
                "key frames",
                0,
                max(show.total, 1),
                1,
                show.kept,
                hint="Keep this many; also the keys + and -",
            )
            self._on(self._count, lambda value: show.set_count(int(value)))

    def _name_level(self, name: Any) -> None:
        """Show a named level, with a note if its features are other ones."""
        show = self._show
        if not needs_other_bundle(show.settings, name):
            show.set_level(name)
            self.note = ""
            return
        recorded = isinstance(show, RecordedShow)
        self.note = f"level {name} has features of its own: segmenting again ..." if recorded else ""
        show.set_level(name)
        done = "segmented again" if recorded else "a new take begins"
        self.note = f"level {name} has features of its own: {done}"

    def _add_playback(self, show: RecordedShow) -> None:
        player, start = show.player, round(show.player.start, 2)
        self._pause = self._gui.add_button("Pause", icon=Icon.PLAYER_PAUSE, hint="Space")
        self._on(self._pause, lambda _: _switch_pause(show))
        self._place = self._gui.add_slider(
            "position (s)", start, max(round(player.end, 2), start + 0.01), 0.01, start
        )
        self._on(self._place, lambda place: player.seek(float(place)))
        given = f"{player.speed:g}"
        speeds = SPEEDS if given in SPEEDS else (given, *SPEEDS)
        speed = self._gui.add_dropdown("speed", speeds, initial_value=given)
        self._on(speed, lambda value: setattr(player, "speed", float(value)))

    def _add_curve(self) -> None:
        settings = self._show.settings.resolved()
        self._threshold = self._slider(
            "threshold", 0.0, 0.3, 0.005, settings.sig_threshold, "sig_threshold", "share of the range"
        )
        self._window = self._slider(
            "window (s)", 0.05, 1.5, 0.05, settings.window, "window", "Starts a new take of a stream"
        )
        self._smoothing = self._gui.add_dropdown(
            "smoothing", get_args(Smoothing), initial_value=settings.smoothing, hint="Starts a new take"
        )
        self._on(self._smoothing, lambda value: self._change({"smoothing": value}))
        self._frames = self._gui.add_slider("over (frames)", 1, 60, 1, min(settings.smoothing_window, 60))
        self._on(self._frames, lambda value: self._change({"smoothing_window": int(value)}))

    def _slider(
        self, label: str, low: float, high: float, step: float, value: float, name: str, hint: str
    ) -> Any:
        """Return a slider that changes a setting."""
        slider = self._gui.add_slider(label, low, high, step, min(max(value, low), high), hint=hint)
        self._on(slider, lambda chosen: self._change({name: float(chosen)}))
        return slider

    def _add_buttons(self) -> None:
        show = self._show
        if isinstance(show, LiveShow):
            self._freeze = self._gui.add_button("Pause", icon=Icon.PLAYER_PAUSE, hint="The stream continues")
            self._on(self._freeze, lambda _: self._freeze_picture(show))
            self._record = self._gui.add_button(
                "Record", icon=Icon.PLAYER_RECORD, hint="Frames, to a .msk file"
            )
            self._on(self._record, lambda _: self._switch_recording(show))
        hint = (
            "Reset: a new take and a new range, as for another person. Save: settings as TOML, for --config."
        )
        self._add_exports()
        others = self._gui.add_button_group("", (_RESET, _SAVE), hint=hint)
        self._on(others, lambda value: show.reset() if value == _RESET else self._save())

    def forget(self, asked: str) -> None:
        """Forget an example of a move; see `TeachingPanel.forget`."""
        if self.teaching is not None:
            self._tasks.ask(self.teaching.forget(asked))

    def _add_exports(self) -> None:
        what = "the whole take" if isinstance(self._show, RecordedShow) else "the last seconds"
        hint = f"Key frames as a table; {what} of the first performer as a picture"
        group = self._gui.add_button_group("export", (_CSV, _PNG), hint=hint)

        async def touched(event: Any) -> None:
            kind, client = event.target.value, event.client
            if client is not None:
                self._tasks.ask(lambda: self._export(kind, client))

        group.on_click(touched)

    def _export(self, kind: str, client: ClientHandle) -> None:
        """Send a file to a browser as a download."""
        show = self._show
        name = show.name if isinstance(show, RecordedShow) else "live"
        if kind == _PNG:
            self.note = "drawing ..."
            performer, content = show.picture(DARK if self.dark else LIGHT)
            file = f"{name}.png" if isinstance(show, RecordedShow) else f"live-{performer}.png"
        else:
            file, content = f"{name}-key-frames.csv", key_frames_csv(show.marks())
        client.send_file_download(file, content, save_immediately=True)
        self.note = f"exported: {file}"

    def _add_keys(self, show: RecordedShow) -> None:
        for key, modifier, step in _STEPS:
            word = "more" if step > 0 else "less"
            command = self._gui.add_command(f"One key frame {word}", hotkey=key, modifier=modifier)
            command.on_trigger(self._asker(_stepper(show, step)))
        pause = self._gui.add_command("Pause or go on", hotkey="space")
        pause.on_trigger(self._asker(lambda: _switch_pause(show)))

    def _on(self, handle: Any, task: Callable[[Any], None]) -> None:
        """Have something done when a person touches a widget.

        Callbacks that are coroutines come in the order of the touches, others from several threads.
        """

        async def touched(event: Any) -> None:
            if event.client is None:
                return
            value = event.target.value
            self._touched[id(handle)] = time.monotonic()
            if button:
                self._tasks.ask(lambda: task(value))
            else:
                self._tasks.ask_latest(id(handle), lambda: task(value))

        button = hasattr(handle, "on_click")
        (handle.on_click if button else handle.on_update)(touched)

    def _asker(self, task: Callable[[], None]) -> Any:
        async def triggered(_: Any) -> None:
            self._tasks.ask(task)

        return triggered

    def _say(self, text: str) -> None:
        self.note = text

    def _change(self, changes: dict[str, object]) -> None:
        self._show.change(changes)

    def _freeze_picture(self, show: LiveShow) -> None:
        show.frozen = not show.frozen
        self._freeze.label = "Go on" if show.frozen else "Pause"
        self._freeze.icon = Icon.PLAYER_PLAY if show.frozen else Icon.PLAYER_PAUSE

    def _switch_recording(self, show: LiveShow) -> None:
        recorder = show.recorder
        if recorder.running:
            recorder.stop()
            self.note = f"recorded: {recorder.path} ({recorder.frames} frames)"
        else:
            recorder.start(self._folder)
            self.note = ""
        self._record.label = "Stop recording" if recorder.running else "Record"
        self._record.color = "red" if recorder.running else None

    def _save(self) -> None:
        show = self._show
        path = save_settings(self._folder, show.settings, show.level, show.strength)
        self.note = f"saved: {path}"
        LOGGER.info("settings saved: %s", path)


def _stepper(show: RecordedShow, step: int) -> Callable[[], None]:
    return lambda: show.step_count(step)


def _switch_pause(show: RecordedShow) -> None:
    show.player.paused = not show.player.paused
