"""Check that a recording is segmented alike whether it is read or comes over a wire: `python -m checks.wires FILE`.

`mossar replay` sends it to `mossar run`, both as processes of their own, and the confirmed key frames are compared with
those of `mossar run FILE` on the joints that the wire carries; of a recording with rotations VMC carries bones, placed
here by its own forward kinematics. Protocols with times must give the same at any speed, the
others with `?fps=`; where the arrival is all there is, the share found within 2 frames is reported.
"""

import argparse
import itertools
import json
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec
import numpy as np

from checks.run_process import RunProcess, free_port
from mossar_adapters.address import parse_url
from mossar_adapters.files.kinematics import joint_positions
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.registry import format_of, open_motion
from mossar_adapters.osc.assembly.humanoid import mapped_bones, present_parents
from mossar_adapters.source import Meta
from mossar_stream import MossarError
from mossar_tools.opening import source_of

NEAR = 2  # frames
_QUIET = 1.5  # s without frames, after which the take has ended
_FOUND = "key_frame.confirmed"


class Wire(msgspec.Struct, frozen=True):
    """One protocol.

    Args:
        name: For the report.
        source: URL of the receiver; `{port}` is a free one.
        sink: URL of the sender.
        times: Whether frames carry their times.
        named: Whether joints carry their names.
    """

    name: str
    source: str
    sink: str
    times: bool = True
    named: bool = True


class Trial(msgspec.Struct, frozen=True):
    """A recording over a wire.

    Args:
        wire: The wire.
        speed: Of the replay.
        fps: Whether the receiver gets the rate; None where it does not matter.
    """

    wire: Wire
    speed: float
    fps: bool | None


_OSC = "osc://127.0.0.1:{port}"
WIRES = (
    Wire("zmq", "zmq+bind://127.0.0.1:{port}", "zmq://127.0.0.1:{port}?wait=60"),
    Wire("osc mossar", _OSC, _OSC),
    Wire("osc vmc", _OSC, _OSC + "?profile=vmc"),
    Wire("osc osceleton", _OSC + "?profile=osceleton&unit=m", _OSC + "?profile=osceleton", times=False),
    Wire("osc kinectv2", _OSC + "?profile=kinectv2", _OSC + "?profile=kinectv2", times=False),
    Wire("osc nimate", _OSC + "?profile=nimate&unit=m", _OSC + "?profile=nimate", times=False),
    Wire("osc flat", _OSC + "?profile=flat&unit=m", _OSC + "?profile=flat", times=False, named=False),
)


def main() -> None:
    """Compare, print a line per trial; exit with 1 if one differs that must not."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument(
        "file", nargs="?", default="demo:?seconds=10", help="a recording of one performer, or demo:"
    )
    parser.add_argument("--wires", help="only these, separated by commas, as in zmq,vmc")
    parser.add_argument("--speeds", default="1,8", help="speeds of the replay (default: 1,8)")
    given = parser.parse_args()
    chosen = given.wires.split(",") if given.wires else None
    wires = [wire for wire in WIRES if chosen is None or wire.name.split()[-1] in chosen]
    try:
        wrong = sum([not _told(given.file, trial) for trial in _trials(wires, given.speeds.split(","))])
    except MossarError as error:
        sys.exit(f"{error}")
    sys.exit(1 if wrong else 0)


def _trials(wires: Sequence[Wire], speeds: Sequence[str]) -> Iterator[Trial]:
    for wire, speed in itertools.product(wires, map(float, speeds)):
        yield Trial(wire, speed, None if wire.times else True)
        if not wire.times and speed == 1.0:
            yield Trial(wire, speed, fps=False)


def _told(file: str, trial: Trial) -> bool:
    """Run a trial, print its result, and return whether it is right."""
    direct, found = compared(file, trial)
    near = sum(any(abs(frame - other) <= NEAR for other in found) for frame in direct)
    times = {None: "the sender's times", True: "?fps=", False: "arrival"}[trial.fps]
    same = (
        "the same" if direct == found else f"{len(found)} found, {near} of {len(direct)} within {NEAR} frames"
    )
    print(f"{trial.wire.name:<14}{trial.speed:>4g}x  {times:<20}{len(direct)} key frames: {same}", flush=True)
    return direct == found or trial.fps is False


def compared(file: str, trial: Trial) -> tuple[list[int], list[int]]:
    """Return the confirmed key frames of a recording, and those that are found at the other end of a wire.

    Raises:
        MossarError: If the recording cannot be read or does not suit the wire.
    """
    wire = trial.wire
    with tempfile.TemporaryDirectory() as folder:
        read = file
        if wire.name == "osc vmc" and _turns(file):
            read = str(_placed_bones(file, Path(folder) / "bones.npz"))
        meta = meta_of(read)
        names, root = meta.skeleton.names, meta.skeleton.root
        joints = (
            [names[i] for i in mapped_bones(names, rotations=False).values()]
            if wire.name == "osc vmc"
            else names
        )
        if names[root] not in joints:
            raise MossarError(f"{file}: {wire.name} does not carry {names[root]}, the centre of the body")
        direct = ["run", read, "--speed", "max", "--joints", ",".join(joints), "--root", names[root]]
        expected = _key_frames(_mossar(*direct, "--to", "-", "--emit", _FOUND))
    there = "Hips" if wire.name == "osc vmc" else names[root] if wire.named else f"joint{root}"
    return expected, _received(file, trial, meta.fps or 0.0, there)


def meta_of(file: str) -> Meta:
    """Return the meta of a recording.

    Raises:
        MossarError: If it cannot be read, or has no rate or centre.
    """
    source = source_of(file, ReadOptions(), speed="max")
    meta = next(item for item in source.items() if isinstance(item, Meta))
    source.close()
    if meta.fps is None or meta.skeleton.root < 0:
        raise MossarError(f"{file}: a rate and a centre of the body are needed for this")
    return meta


def _turns(file: str) -> bool:
    """Return whether a recording has rotations, which VMC then carries."""
    address = parse_url(file)
    return address.scheme == "file" and format_of(Path(address.path)).motion


def _placed_bones(file: str, path: Path) -> Path:
    """Write where a recording's own forward kinematics puts the bones that VMC carries."""
    motion = open_motion(Path(parse_url(file).path))
    found = mapped_bones(motion.names, rotations=True)
    chunks = list(motion.chunks())
    places = [joint_positions(chunk, motion.parents)[:, list(found.values())] for chunk in chunks]
    np.savez(
        path,
        positions=np.concatenate(places).astype(np.float32),
        times=np.concatenate([chunk.times for chunk in chunks]),
        joint_names=np.array(list(found)),
        parents=np.array(present_parents(list(found))),
    )
    return path


def _received(file: str, trial: Trial, fps: float, root: str) -> list[int]:
    """Replay a recording to a `mossar run`, and return the frames of the confirmed key frames there."""
    wire = trial.wire
    port = free_port(socket.SOCK_DGRAM if wire.source.startswith("osc") else socket.SOCK_STREAM)
    source = wire.source.format(port=port)
    if trial.fps:
        source += f"{'&' if '?' in source else '?'}fps={fps!r}"
    with tempfile.TemporaryFile() as lines:
        with RunProcess(source, "-", "--emit", _FOUND, "--root", root, output=lines) as run:
            _mossar(
                "replay", file, "--to", wire.sink.format(port=port), "--speed", f"{trial.speed:g}", "--quiet"
            )
            run.settled_stats(_QUIET)
        lines.seek(0)
        return _key_frames(lines.read())


def _mossar(*arguments: str) -> bytes:
    command = [sys.executable, "-m", "mossar_tools", *arguments]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=False)  # noqa: S603
    if done.returncode:
        raise MossarError(done.stderr.decode().strip())
    return done.stdout


def _key_frames(lines: bytes) -> list[int]:
    return [json.loads(line)["frame"] for line in lines.splitlines()]


if __name__ == "__main__":
    main()
