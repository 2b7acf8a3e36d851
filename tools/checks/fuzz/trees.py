"""Targets fed by Hypothesis: input whose form is right and whose values are anything.

Damaged bytes rarely get past the first look of a decoder; these do.
"""

import itertools
import random
from collections.abc import Callable
from typing import Any

import hypothesis
import msgspec
from hypothesis import strategies as st

from checks.fuzz.target import ROUND, Draw, Target
from mossar_adapters.osc.encode import encode
from mossar_stream import Settings

_numbers = st.integers(-(2**62), 2**62) | st.floats()
_texts = st.text(max_size=12) | st.sampled_from(["p1", "none", "auto", "1e999", "motion", "meta", "frame"])
_leaves = st.none() | st.booleans() | _numbers | _texts
_trees = st.recursive(
    _leaves,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(_texts, inner, max_size=3),
    max_leaves=12,
)
_row = st.none() | st.tuples(*[st.none() | st.floats()] * 3)
_rows = st.lists(_row, min_size=2, max_size=2) | st.lists(_row, max_size=5)
_names = st.just(["a", "b"]) | st.lists(_texts, max_size=5)
_rates = st.none() | st.just(60.0) | st.floats()


def _map(kind: str, **fields: st.SearchStrategy[Any]) -> st.SearchStrategy[dict[str, Any]]:
    """Return maps with these fields, up to two of them of any kind."""
    odd = st.dictionaries(st.sampled_from([*fields, "type", "more"]), _trees, max_size=2)
    right = st.fixed_dictionaries({"type": st.just(kind), **fields})
    return st.tuples(right, odd).map(lambda pair: {**pair[0], **pair[1]})


_maps = _map(
    "frame",
    performer=_texts,
    seq=st.integers(-(2**63), 2**64 - 1),
    t=st.floats(),
    shape=st.none() | st.tuples(st.integers(0, 5), st.just(3)),
    xyz=_rows,
    conf=st.none() | st.lists(st.floats(), max_size=5),
) | _map(
    "meta",
    performer=_texts,
    names=_names,
    parents=st.just([]) | st.just([-1, 0]) | st.lists(st.integers(-2, 5), max_size=5),
    root=st.integers(-1, 1) | st.integers(-(2**63), 2**63 - 1),
    fps=_rates,
    unit=st.just("m") | _texts,
)
_changes = st.dictionaries(
    st.sampled_from([*Settings.__struct_fields__, "features.positions", "variance_floor.distances"]),
    _trees,
    max_size=3,
)
_requests = st.fixed_dictionaries(
    {}, optional={"set": _changes | _trees, "get": _texts, "do": _texts, "performer": _texts}
)
_addresses = st.sampled_from(
    [
        "/joint",
        "/joint/head/1",
        "/VMC/Ext/Bone/Pos",
        "/VMC/Ext/Root/Pos",
        "/VMC/Ext/T",
        "/VMC/Ext/OK",
        "/pose",
        "/bodies/7/joints/Head",
        "/skeleton_head",
        "/mossar/meta",
        "/mossar/frame",
        "/lost_user",
        "/pose/a/b",
    ]
)
_arguments = st.lists(
    st.tuples(st.just("s"), _texts)
    | st.tuples(st.just("b"), st.binary(max_size=40))
    | st.tuples(st.sampled_from("fd"), st.floats(width=32))
    | st.tuples(st.sampled_from("ih"), st.integers(-(2**31), 2**31 - 1)),
    max_size=9,
)


def drawn_targets(targets: list[Target]) -> list[Target]:
    """Return targets that feed the readers of some of these targets with drawn input."""
    opens = {target.name: target.open for target in targets}
    osc = st.tuples(_addresses, _arguments)
    kinds: list[tuple[str, str, st.SearchStrategy[Any], Callable[[Any], bytes]]] = [
        ("osc auto", "drawn osc", osc, _encoded),
        ("zeromq msgpack", "drawn msgpack", _maps, msgspec.msgpack.encode),
        ("zeromq json", "drawn json", _maps, msgspec.json.encode),
        ("control", "drawn control", _requests, msgspec.json.encode),
    ]
    return [Target(name, 0.3, opens[of], draw=_draw(tree, encoded)) for of, name, tree, encoded in kinds]


def _encoded(message: tuple[str, list[tuple[str, Any]]]) -> bytes:
    address, arguments = message
    return encode(address, "".join(tag for tag, _ in arguments), *(value for _, value in arguments))


def _draw(tree: st.SearchStrategy[Any], encoded: Callable[[Any], bytes]) -> Draw:
    def draw(rng: random.Random) -> Callable[[], bytes]:
        found: list[bytes] = []

        @hypothesis.seed(rng.getrandbits(64))
        @hypothesis.settings(
            max_examples=ROUND,
            database=None,
            deadline=None,
            phases=(hypothesis.Phase.generate,),
            suppress_health_check=list(hypothesis.HealthCheck),
        )
        @hypothesis.given(tree)
        def collect(value: Any) -> None:
            found.append(encoded(value))

        collect()
        return itertools.cycle(found).__next__

    return draw
