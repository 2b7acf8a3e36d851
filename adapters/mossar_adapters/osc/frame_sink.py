"""The OSC frame sink of `mossar replay`, in any profile that can carry positions."""

import numpy as np

from mossar_adapters.address import Address
from mossar_adapters.files.kinematics import JointMotion, MotionChunk
from mossar_adapters.osc import frame_writers
from mossar_adapters.osc.encode import bundles
from mossar_adapters.osc.frame_writers import Writer, mossar_meta
from mossar_adapters.osc.sender import DatagramSender
from mossar_adapters.osc.vmc_writer import MotionBones, PositionBones, datagrams
from mossar_adapters.source import Meta
from mossar_stream import Frames

_WRITERS: dict[str, Writer] = {
    "mossar": frame_writers.mossar,
    "osceleton": frame_writers.osceleton,
    "kinectv2": frame_writers.kinectv2,
    "nimate": frame_writers.nimate,
    "flat": frame_writers.flat,
}
PROFILES = (*_WRITERS, "generic", "vmc")
OPTIONS = {
    "profile": f"one of {', '.join(PROFILES)}; default mossar",
    "pattern": "address with placeholders (generic)",
    "args": "arguments (generic)",
}
VMC_OPTIONS = {"profile": OPTIONS["profile"], "positions": "yes or no: whether bones carry positions"}
_REPEAT = 1.0  # s of source time between two metas, for receivers that join late


def open_osc_frame_sink(address: Address) -> "OscFrameSink | VmcFrameSink":
    """Return the sink for the profile in the URL.

    Raises:
        MossarError: If the host is unknown or an option is wrong.
    """
    if address.choice("profile", PROFILES, "mossar") == "vmc":
        return VmcFrameSink(address)
    return OscFrameSink(address)


class OscFrameSink:
    """Sends joint positions; implements `FrameSink`.

    Args:
        address: `osc://HOST:PORT?profile=…`.
    """

    def __init__(self, address: Address) -> None:
        address.check(OPTIONS)
        self.name = address.url
        profile = address.choice("profile", PROFILES, "mossar")
        self._write = frame_writers.generic(address) if profile == "generic" else _WRITERS[profile]
        self._bundled = profile not in {"mossar", "flat"}
        self._repeats = profile == "mossar"
        self._sender = DatagramSender(address)
        self._metas: dict[str, Meta] = {}
        self._counts: dict[str, int] = {}
        self._repeated: dict[str, float] = {}  # performer -> time of the latest meta, s

    @property
    def dropped(self) -> int:
        """Datagrams that the system did not take."""
        return self._sender.dropped

    def announce(self, meta: Meta) -> None:
        """Note a performer."""
        self._metas[meta.performer] = meta
        self._repeated.pop(meta.performer, None)

    def send_frames(self, frames: Frames) -> None:
        """Send frames, in bundles where a frame has several messages."""
        meta = self._metas[frames.performer]
        for i, time in enumerate(frames.times.tolist()):
            if self._repeats and not abs(time - self._repeated.get(meta.performer, np.inf)) < _REPEAT:
                self._repeated[meta.performer] = time
                self._sender.send(mossar_meta(meta))
            seq = self._counts.get(meta.performer, 0)
            self._counts[meta.performer] = seq + 1
            confidence = None if frames.confidence is None else frames.confidence[i]
            messages = self._write(meta, seq, time, frames.positions[i], confidence)
            for data in bundles(messages) if self._bundled else messages:
                self._sender.send(data)

    def close(self) -> None:
        """Release the socket. May be called twice."""
        self._sender.close()


class VmcFrameSink:
    """Sends humanoid bones; implements `FrameSink`, and sends rotations where the recording has them.

    One sink sends one performer: VMC has no ids, receivers distinguish avatars by port.

    Args:
        address: `osc://HOST:PORT?profile=vmc`.
    """

    def __init__(self, address: Address) -> None:
        address.check(VMC_OPTIONS)
        self.name = address.url
        self._rotations_only = address.choice("positions", ("yes", "no"), "yes") == "no"
        self._sender = DatagramSender(address)
        self._performer: str | None = None
        self._bones: PositionBones | None = None
        self._turning: MotionBones | None = None

    @property
    def dropped(self) -> int:
        """Datagrams that the system did not take."""
        return self._sender.dropped

    def announce(self, meta: Meta) -> None:
        """Note the performer; the first one is sent.

        Raises:
            MossarError: If its joints are not called like those of a humanoid.
        """
        if self._performer in {None, meta.performer}:
            self._performer = meta.performer
            self._bones = PositionBones(meta.skeleton)

    def announce_motion(self, motion: JointMotion) -> None:
        """Note a recording with rotations; its chunks go to `send_motion`.

        Raises:
            MossarError: If its joints are not called like those of a humanoid.
        """
        self._turning = MotionBones(motion, rotations_only=self._rotations_only)

    def send_frames(self, frames: Frames) -> None:
        """Send joint positions as bones that do not turn."""
        if self._bones is None or frames.performer != self._performer:
            return
        pose = self._bones.pose(frames.positions)
        for i, time in enumerate(frames.times.tolist()):
            for data in datagrams(pose, i, time):
                self._sender.send(data)

    def send_motion(self, chunk: MotionChunk) -> None:
        """Send rotations, and positions unless the URL excludes them."""
        if self._turning is None:
            raise ValueError("announce_motion comes before send_motion")
        pose = self._turning.pose(chunk)
        for i, time in enumerate(chunk.times.tolist()):
            for data in datagrams(pose, i, time):
                self._sender.send(data)

    def close(self) -> None:
        """Release the socket. May be called twice."""
        self._sender.close()
