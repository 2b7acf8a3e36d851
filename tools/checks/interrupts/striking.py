"""Striking: Ctrl-C where the interpreter would raise it, at a place that is counted."""

import dis
import functools
import sys
from collections.abc import Callable
from pathlib import Path
from types import CodeType, FrameType, TracebackType
from typing import Any

import mossar_stream

CORE = str(Path(mossar_stream.__file__).parent)


class Striking:
    """Raises KeyboardInterrupt in code of the core where the interpreter would: as functions begin, loops go on, calls return.

    Args:
        after: How many such places are passed over before.
    """

    def __init__(self, after: int) -> None:
        self.left, self.has_struck = after, False
        self._before: dict[int, str] = {}

    def __enter__(self) -> None:
        sys.settrace(self._call)

    def __exit__(self, kind: type[BaseException] | None, _: object, __: TracebackType | None) -> bool:
        sys.settrace(None)
        return kind is KeyboardInterrupt

    def _call(self, frame: FrameType, _event: str, _argument: object) -> Callable[..., Any] | None:
        if not frame.f_code.co_filename.startswith(CORE):
            return None
        frame.f_trace_opcodes, frame.f_trace_lines = True, False
        return self._opcode

    def _opcode(self, frame: FrameType, event: str, _argument: object) -> Callable[..., Any]:
        if event == "opcode":
            name = _names_of(frame.f_code)[frame.f_lasti]
            if name in ("NOP", "JUMP_FORWARD"):  # on the way to a return
                return self._opcode
            before, self._before[id(frame)] = self._before.get(id(frame)), name
            # A call of Python does not look before it returns, unless its arguments are unpacked.
            returned = before == "CALL_FUNCTION_EX" or (before == "CALL" and name != "RETURN_VALUE")
            if name in ("RESUME", "JUMP_BACKWARD") or returned:
                self.left -= 1
                if self.left == 0:
                    self.has_struck = True
                    raise KeyboardInterrupt
        return self._opcode


@functools.cache
def _names_of(code: CodeType) -> dict[int, str]:
    return {step.offset: step.opname for step in dis.get_instructions(code)} | dict.fromkeys([-1], "")
