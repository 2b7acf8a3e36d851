"""Control: requests to a running pipeline, from ZeroMQ or OSC.

A request is `{"set": {"level": "motion"}}`, `{"get": "settings"}`, `{"get": "stats"}` or `{"do": "reset"}`, each with
an optional `"performer"`; the answer is `{"ok": true, "value": …}` or `{"ok": false, "error": "…"}`; that to `set` also has
`"new_take": true` if it ended a take. The thread that segments carries out a request between two
chunks of frames.

`{"set": {"follow": ["squat"]}}` follows these moves of `--moves` from now on, of all performers; `"all"` follows all, `[]` none.
`{"get": "following"}` returns where each performer is in each of them.

Where a source has slots (`--people`): `{"get": "people"}`, `{"set": {"people": 3, "remember": 60}}`,
`{"do": "exchange", "performers": ["p1", "p2"]}`, `{"do": "pin", "performer": "p1"}` and `unpin`.
"""

import logging
import threading
from collections.abc import Sequence
from typing import Any

import msgspec

from mossar_adapters.pipeline import Pipeline
from mossar_adapters.pipeline.outcome import in_words
from mossar_adapters.pipeline.slots_of_run import exchange, pin, slots_by_source, sources_with_slots
from mossar_stream import MossarError, SettingsError

PATIENCE = 5.0  # s until a request that the pipeline does not get round to is given up
MAX_REQUEST = 1 << 16  # bytes

_OF_PEOPLE = ("exchange", "pin", "unpin")
_OF_SLOTS = {"people", "remember"}
FOLLOW, EVERY = "follow", "all"

Follow = tuple[str, ...] | bool  # names of moves; True for all

_log = logging.getLogger("mossar.control")


class Request(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One of `set`, `get` and `do`."""

    set: dict[str, Any] | None = None
    get: str | None = None
    do: str | None = None
    performer: str | None = None
    performers: tuple[str, ...] = ()


class Control:
    """Carries requests out. Any thread may call its methods.

    Args:
        pipeline: The controlled pipeline.
    """

    def __init__(self, pipeline: Pipeline) -> None:
        self._pipeline = pipeline

    def answer(self, message: bytes) -> bytes:
        """Return the answer to a request, both JSON."""
        try:
            if len(message) > MAX_REQUEST:
                raise SettingsError(f"a request has at most {MAX_REQUEST} bytes")
            request = msgspec.json.decode(message, type=Request)
            return msgspec.json.encode({"ok": True, **self._wait_for(request)})
        except (MossarError, ValueError, TypeError, RecursionError) as error:
            return msgspec.json.encode({"ok": False, "error": str(error)})

    def apply(self, address: str, arguments: Sequence[Any]) -> None:
        """Carry out an OSC message, `/mossar/set/<name> value` or `/mossar/reset`, without waiting.

        Errors go to the log: the sender does not wait for an answer.
        """
        parts = address.strip("/").split("/")
        if parts == ["mossar", "reset"]:
            request = Request(do="reset")
        elif len(parts) == 3 and parts[:2] == ["mossar", "set"] and len(arguments) == 1:
            request = Request(set={parts[2]: arguments[0]})
        else:
            _log.warning(
                "control: %s is neither /mossar/set/NAME with a value nor /mossar/reset", address[:60]
            )
            return
        self._pipeline.ask(lambda: _applied(self._pipeline, request))

    def _wait_for(self, request: Request) -> dict[str, object]:
        """Have a request carried out by the thread that segments, and return its result."""
        results: list[dict[str, object] | Exception] = []
        done = threading.Event()

        def carry() -> None:
            try:
                results.append(carry_out(self._pipeline, request))
            except Exception as error:  # noqa: BLE001 - no request may end the run
                results.append(error)
            done.set()

        self._pipeline.ask(carry)
        if not done.wait(PATIENCE):
            raise SettingsError("the pipeline is busy or has ended")
        if isinstance(results[0], Exception):
            raise SettingsError(in_words(results[0]))
        return results[0]


def carry_out(pipeline: Pipeline, request: Request) -> dict[str, object]:
    """Carry out a request in the thread that segments, and return the content of the answer: `value`, and more.

    Raises:
        SettingsError: If the request is impossible; nothing is changed then.
    """
    asked = [name for name in ("set", "get", "do") if getattr(request, name) is not None]
    if len(asked) != 1:
        raise SettingsError('a request has one of "set", "get" and "do"')
    if request.get == "people" or request.do in _OF_PEOPLE or _OF_SLOTS & (request.set or {}).keys():
        value = of_people(pipeline, request)
        if request.get is None:
            pipeline.upkeep.save(pipeline)
        return {"value": value}
    pool, performer = pipeline.pool, request.performer
    if FOLLOW in (request.set or {}):
        return {"value": {FOLLOW: set_follow(pipeline, request)}}
    if performer is not None and performer not in pool:
        raise SettingsError(
            f"no performer called {performer[:40]!r}; there are {', '.join(sorted(pool.names))}"
        )
    performers = sorted(pool.names) if performer is None else [performer]
    if request.set is not None:
        ended = pipeline.set(request.set, performer)
        return {"value": request.set, **({"new_take": True} if ended else {})}
    if request.get == "settings":
        return {"value": (pool.settings if performer is None else pool[performer].settings).resolved()}
    if request.get == "stats":
        return {"value": {name: pipeline.upkeep.stats_of(pipeline, name) for name in performers}}
    if request.get == "following":
        return {"value": {name: pool[name].following for name in performers}}
    if request.do == "reset":
        for name in performers:
            pipeline.send(pool.reset(name, "asked for"))
        return {"value": performers}
    if request.get is not None:
        raise SettingsError(
            f"cannot get {request.get[:40]!r}; there are settings, stats, following and people"
        )
    raise SettingsError(f"cannot do {str(request.do)[:40]!r}; there are reset, exchange, pin and unpin")


def set_follow(pipeline: Pipeline, request: Request) -> Follow:
    """Follow other moves, and return which.

    Raises:
        SettingsError: If there are no moves, or none of a name, or it is of one performer.
    """
    wanted = (request.set or {})[FOLLOW]
    if request.performer is not None or len(request.set or {}) > 1:
        raise SettingsError("follow is set by itself, for all performers")
    if isinstance(wanted, str):
        wanted = [name.strip() for name in wanted.split(",") if name.strip()]
    if not isinstance(wanted, list) or not all(isinstance(name, str) for name in wanted):
        raise SettingsError(f"follow takes names of moves or all, not {str(wanted)[:40]}")
    pipeline.pool.follow = EVERY in wanted or tuple(wanted)
    return pipeline.pool.follow


def of_people(pipeline: Pipeline, request: Request) -> object:
    """Carry out a request about slots, and return them: the person in each, by source.

    Raises:
        SettingsError: If no source has slots, there is no such slot, or a value is impossible.
    """
    found = sources_with_slots(pipeline)
    if not found:
        raise SettingsError("no source has slots: start with --people")
    if request.set is not None and (others := request.set.keys() - _OF_SLOTS):
        raise SettingsError(
            f"people and remember are set by themselves, not with {', '.join(sorted(others))}"
        )
    slots = (*request.performers, *([request.performer] if request.performer else ()))
    if request.do is not None and len(slots) != (2 if request.do == "exchange" else 1):
        raise SettingsError('exchange has "performers" with two slots; pin and unpin have one "performer"')
    if request.set is not None:
        for source in found.values():
            source.set(**request.set)
    elif request.do == "exchange":
        exchange(pipeline, *slots)
    elif request.do is not None:
        pin(pipeline, slots[0], pinned=request.do == "pin")
    return slots_by_source(pipeline)


def _applied(pipeline: Pipeline, request: Request) -> None:
    try:
        carry_out(pipeline, request)
    except Exception as error:  # noqa: BLE001 - no request may end the run
        _log.warning("control: %s", in_words(error))
