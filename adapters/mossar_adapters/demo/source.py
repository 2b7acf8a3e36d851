"""The built-in performers as a source of frames: `demo:`."""

import itertools
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final, Literal
from urllib.parse import parse_qsl, urlsplit

from mossar_adapters.demo.body import SKELETON
from mossar_adapters.demo.stream import Cut, stream
from mossar_adapters.demo.style import Style
from mossar_adapters.replay.interleaving import part
from mossar_adapters.replay.pacing import Pacer
from mossar_adapters.source import Meta
from mossar_stream import Frames, SettingsError, performer_name

MAX_PERFORMERS: Final = 64
KNOWN_CUTS: Final = 1000  # per performer; older ones are forgotten
SPACING: Final = 2.0  # m between neighbouring performers

_CHUNK: Final = 1 / 30  # s of frames in a chunk
_IDLE: Final = 0.1  # s without frames after which a live source yields None

# URL options: the parser of their text, and a description of legal values.
_OPTIONS: Final[dict[str, tuple[Callable[[str], Any], str]]] = {
    "seed": (int, "a whole number from 0"),
    "performers": (int, f"a whole number, 1 to {MAX_PERFORMERS}"),
    "performer": (str, "the name of a single performer"),
    "seconds": (float, "a positive number"),
    "moves": (lambda text: tuple(text.split(",")), "moves separated by commas"),
    "fps": (float, "a number, 1 to 1000"),
    "tempo": (float, "a number, 0.2 to 5"),
    "noise": (float, "metres, 0 to 1"),
    "noise_kind": (str, "white or kinect"),
    "jitter": (float, "seconds, 0 to 0.1"),
    "drop": (float, "a share, 0 to 0.9"),
}


class DemoSource:
    """Performers without end, or until their moves or seconds are over; implements `Source`.

    Performer k of several is called `pk` and is the performer of seed `seed` + k - 1, `SPACING` metres to the
    left of the one before. Their chunks come in order of time. The same arguments give the same chunks.

    Args:
        seed: 0 or more.
        style: Rate, tempo and sensor.
        performers: Number of performers.
        performer: Name of a single performer.
        seconds: Where to stop.
        moves: The moves, see `performance`; None for default moves.
        speed: 1 is real time, "max" does not wait.
        name: The URL, for messages.

    Raises:
        SettingsError: If a value is out of its range or there is no such move.
        ValueError: If `speed` is neither a positive number nor "max".

    Example:
        >>> source = DemoSource.from_url("demo:?seed=3&seconds=1&performers=2", speed="max")
        >>> sum(len(item) for item in source.items() if isinstance(item, Frames))
        120
    """

    def __init__(
        self,
        seed: int = 1,
        style: Style | None = None,
        *,
        performers: int = 1,
        performer: str | None = None,
        seconds: float | None = None,
        moves: Sequence[str] | None = None,
        speed: float | Literal["max"] = 1.0,
        name: str = "demo:",
    ) -> None:
        if not 1 <= performers <= MAX_PERFORMERS:
            raise SettingsError(f"performers must lie in 1 to {MAX_PERFORMERS}, not {performers}")
        if performer is not None and performers > 1:
            raise SettingsError(f"performer names a single performer, not {performers}")
        self.name = name
        self.live = speed != "max"
        self.pacer = Pacer(speed)
        self._style = style or Style()
        self._closed = False
        self._names = [performer_name(performer or f"p{k + 1}") for k in range(performers)]
        self._cuts: dict[str, tuple[Cut, ...]] = dict.fromkeys(self._names, ())
        self._feeds = [
            _Feed(
                stream(
                    seed + k,
                    self._style,
                    moves=moves,
                    seconds=seconds,
                    performer=performer,
                    place=(SPACING * k, 0.0),
                )
            )
            for k, performer in enumerate(self._names)
        ]

    @classmethod
    def from_url(cls, url: str, *, speed: float | Literal["max"] = 1.0) -> "DemoSource":
        """Return the source that `url` describes, as in `demo:?seed=3&noise=0.01&performers=2`.

        Raises:
            SettingsError: If an option is unknown or its value impossible.
        """
        parts = urlsplit(url)
        if parts.scheme != "demo" or parts.netloc or parts.path or parts.fragment:
            raise SettingsError(f"{url[:80]!r} is not of the form demo: or demo:?seed=3&noise=0.01")
        options = _read_options(parts.query)
        given = {name: options.pop(name) for name in Style.__struct_fields__ if name in options}
        try:
            return cls(style=Style(**given), speed=speed, name=url, **options)
        except SettingsError as error:
            raise SettingsError(f"demo: {error}") from None

    @property
    def performers(self) -> tuple[str, ...]:
        """Names of all performers there will ever be."""
        return tuple(self._names)

    @property
    def cuts(self) -> dict[str, tuple[Cut, ...]]:
        """The true cuts in the frames yielded so far, per performer; the last `KNOWN_CUTS` of each."""
        return dict(self._cuts)

    def items(self) -> Iterator[Meta | Frames | None]:
        """Yield a meta per performer, then chunks of about 1/30 s; None while paused or slow.

        To be iterated once.
        """
        yield from (Meta(name, SKELETON, self._style.fps, recording=self.name) for name in self._names)
        per_chunk = max(1, round(self._style.fps * _CHUNK))
        for chunk in itertools.count(1):
            until = chunk * per_chunk / self._style.fps
            parts = [part for feed in self._feeds for part in feed.before(until)]
            parts.sort(key=lambda part: float(part[0].times[0]))
            due = max((float(frames.times[-1]) for frames, _ in parts), default=0.0)
            while parts and not self.pacer.wait_until(due, timeout=_IDLE):
                if self._closed:
                    return
                yield None
            for frames, cuts in parts:
                known = (*self._cuts[frames.performer], *cuts)
                self._cuts[frames.performer] = known[-KNOWN_CUTS:]
                yield frames
            if self._closed or all(feed.ended for feed in self._feeds):
                return

    def close(self) -> None:
        """End `items` soon. May be called twice, and from any thread."""
        self._closed = True
        self.pacer.interrupt()


class _Feed:
    """Hands out the blocks of one performer in smaller pieces."""

    def __init__(self, blocks: Iterator[tuple[Frames, tuple[Cut, ...]]]) -> None:
        self._blocks = blocks
        self._rest: Frames | None = None
        self._cuts: deque[Cut] = deque()
        self.ended = False

    def before(self, until: float) -> Iterator[tuple[Frames, list[Cut]]]:
        """Yield the next frames up to the time `until` (s), each piece with the cuts that lie in it."""
        while not self.ended:
            block = self._rest if self._rest is not None else self._next_block()
            count = 0 if block is None else int(block.times.searchsorted(until))
            if block is None or count == 0:
                return
            piece, self._rest = _split(block, count)
            end = (piece.first_frame or 0) + count
            yield piece, [self._cuts.popleft() for cut in tuple(self._cuts) if cut.frame < end]

    def _next_block(self) -> Frames | None:
        self._rest, cuts = next(self._blocks, (None, ()))
        self._cuts.extend(cuts)
        self.ended = self._rest is None
        return self._rest


def _split(frames: Frames, count: int) -> tuple[Frames, Frames | None]:
    """Return the first `count` frames and the rest, None if there is none."""
    return part(frames, 0, count), None if count == len(frames) else part(frames, count, len(frames))


def _read_options(query: str) -> dict[str, Any]:
    """Return the values of the URL options, each with its type.

    Raises:
        SettingsError: If an option is unknown, given twice, or cannot be read.
    """
    options: dict[str, Any] = {}
    for name, text in parse_qsl(query, keep_blank_values=True):
        if name not in _OPTIONS:
            raise SettingsError(f"demo: has no option {name[:40]!r}; there are {', '.join(_OPTIONS)}")
        if name in options:
            raise SettingsError(f"demo: option {name} is given twice")
        read, legal = _OPTIONS[name]
        try:
            options[name] = read(text)
        except ValueError:
            raise SettingsError(f"demo: option {name} must be {legal}, not {text[:40]!r}") from None
    return options
