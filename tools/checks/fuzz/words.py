"""Targets that read text of users: URLs, settings, configuration; and control requests."""

import argparse
import contextlib
from collections.abc import Iterator

from checks.fuzz.files import scratch
from checks.fuzz.target import Feed, Target
from mossar_adapters.address import numeric_host, parse_url
from mossar_adapters.control.requests import Control
from mossar_adapters.demo import DemoSource
from mossar_adapters.osc.profiles.generic import checked_args, checked_pattern
from mossar_adapters.pipeline import Pipeline
from mossar_adapters.receiving.admission import AllowList
from mossar_adapters.source import Meta
from mossar_stream import Frames, MossarError, Settings
from mossar_tools.commands import run
from mossar_tools.configuration import known_names
from mossar_tools.declared import add_options
from mossar_tools.options import parse
from mossar_tools.parser import Parser

_URLS = (
    b"osc://127.0.0.1:39539?profile=vmc&fps=60&performer=ann",
    b"osc://[::1]:9000?profile=generic&pattern=/pose/{performer}/{joint}&args=xyzc_",
    b"osc://0.0.0.0:7110?allow=192.168.0.7,10.0.0.0/8",
    b"zmq+bind://127.0.0.1:5556?encoding=json&key=/tmp/a.key_secret",
    b"zmq+ipc:///tmp/pose",
    b"ws://localhost:8765?origin=https://game.example,http://localhost:8000",
    b"demo:?seed=3&noise=0.01&performers=2&moves=walk,punch&seconds=2",
    b"lsl:?name=body",
    b"oak:?device=14442C10D13EABCE00",
    b"file:///tmp/take%20one.bvh",
    b"C:\\takes\\one.bvh",
)
_REQUESTS = (
    b'{"set":{"level":"motion"}}',
    b'{"set":{"window":0.3,"sig_threshold":0.05},"performer":"p1"}',
    b'{"set":{"features":{"positions":1,"distances":0,"log_speed":0.5}}}',
    b'{"set":{"features.positions":"0.5","tempo":"true"}}',
    b'{"get":"settings"}',
    b'{"get":"stats","performer":"p1"}',
    b'{"do":"reset"}',
)
_SETTINGS = (
    b"level=cluster\nwindow=0.3\nsig_threshold=0.04",
    b"features=positions:0.75,log_speed:0.25\nvariance_floor.positions=1e-4",
    b"similarity=path_kernel\nedges=20\nlayers=2\nkernel_form=sum",
    b"range=fixed\nrange_min=0\nrange_max=1.5\nsmoothing=one_euro",
    b"location=none\nrefine=0.1\ntempo=true\nmax_key_frames=none",
)
_TOML = (
    b'preset = "game"\nto = ["osc://127.0.0.1:9000", "events.jsonl"]\nemit = "confirmed,final"\nseconds = 10\n',
    b"sources = ['demo:']\nstats = 5.0\nquiet = true\n[settings]\nsig_threshold = 0.04\nfeatures = {positions = 1.0}\n",
    b'level = 1.5\nspeed = "max"\njoints = ["hip", "head"]\nperformer = "ann"\nport = 8080\nlog-level = "debug"\n',
)
_NAMES = tuple(name.encode() for name in (*Settings.__struct_fields__, *sorted(known_names())))


def word_targets() -> list[Target]:
    """Return the targets."""
    return [
        Target(
            "urls",
            12.0,
            _urls,
            _URLS,
            (b"?", b"&", b"=", b"[::1]", b":65536", b"@", b"#", b"%2", *_NAMES[:9]),
        ),
        Target("settings", 5.0, _settings, _SETTINGS, _NAMES),
        Target(
            "configuration", 1.0, _configuration, _TOML, (b"[settings]\n", b"[[a]]\n", b"1979-05-27", *_NAMES)
        ),
        Target("control", 4.0, _control, _REQUESTS, _NAMES),
    ]


@contextlib.contextmanager
def _urls() -> Iterator[Feed]:
    def feed(data: bytes) -> None:
        address = parse_url(data.decode("utf-8", "surrogateescape"))
        numeric_host(address.host)
        address.host_port()
        AllowList(address)
        address.number("fps", 0.001, 1e5)
        address.choice("encoding", ("msgpack", "json"), "msgpack")
        if "pattern" in address.options:
            checked_pattern(address)
            checked_args(address)
        if address.scheme == "demo":
            DemoSource.from_url(address.url, speed="max")
        address.required_port()

    yield feed


@contextlib.contextmanager
def _settings() -> Iterator[Feed]:
    def feed(data: bytes) -> None:
        lines = data.decode("utf-8", "replace").split("\n")
        pairs = [line.partition("=") for line in lines]
        Settings.build("default", {name: value for name, _, value in pairs}).resolved()

    yield feed


@contextlib.contextmanager
def _configuration() -> Iterator[Feed]:
    parser = Parser(prog="mossar run", argument_default=argparse.SUPPRESS, allow_abbrev=False)
    add_options(parser, run.Options)
    with scratch() as folder:
        path = folder / "mossar.toml"

        def feed(data: bytes) -> None:
            path.write_bytes(data)
            parse(parser, run.Options, ["--config", str(path)]).segmentation.settings()

        yield feed


class _Prompt(Pipeline):
    """A pipeline that carries out requests at once: there is no other thread."""

    def ask(self, request: object) -> None:
        if callable(request):
            request()


@contextlib.contextmanager
def _control() -> Iterator[Feed]:
    source = DemoSource(1, seconds=0.2, speed="max")
    pipeline = _Prompt([source], [])
    for item in source.items():
        if isinstance(item, Meta):
            pipeline.naming.performer(0, item.performer)
            pipeline.pool.announce(item.performer, item.skeleton, item.fps)
        elif isinstance(item, Frames):
            pipeline.pool.push(item)
    control = Control(pipeline)

    def feed(data: bytes) -> None:
        answer = control.answer(data)
        if answer.startswith(b'{"ok":false'):
            raise MossarError(answer.decode())

    yield feed
