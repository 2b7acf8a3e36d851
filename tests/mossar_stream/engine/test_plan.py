"""What a performer takes of memory is what the documentation says."""

import re
from pathlib import Path

import pytest

from mossar_adapters.demo import SKELETON
from mossar_stream import Settings, Skeleton
from mossar_stream.core.kernels import move_memory_bytes, move_store_bytes
from mossar_stream.core.plan import Plan
from mossar_stream.moves.groups import groups_of
from mossar_stream.segmenter.limbs import settings_of_limbs

ROOT = Path(__file__).parents[3]
LEVELS = ("motion", "posture", "cluster")


def kilobytes(skeleton, settings):
    return round(Plan(skeleton, settings, 120.0).row_bytes / 1000)


def said(page, pattern):
    found = re.search(pattern, (ROOT / page).read_text(encoding="utf-8"))
    return [float(number) for number in found.groups()]


@pytest.mark.parametrize("page", ["README.md", "docs/measurements.md"])
def test_memory_of_a_performer(page):
    skeleton = Skeleton(tuple(f"joint{j}" for j in range(31)), (-1, *range(30)))
    sizes = [kilobytes(skeleton, Settings(level=level)) for level in LEVELS]
    assert said(page, r"31 joints,? ?(?::|level) .*\| (\d+) / (\d+) / (\d+) kB") == sizes


def test_memory_of_limbs():
    own = settings_of_limbs(Settings(limbs=True))
    groups = groups_of(SKELETON, wanted=True)
    limbs = [Plan(limb.skeleton, own, 120.0, channel=limb.name).row_bytes for limb in groups]
    assert (len(SKELETON), len(limbs)) == (21, 5)
    sizes = [kilobytes(SKELETON, Settings()), round(sum(limbs) / 1000)]
    assert said("docs/limbs.md", r"body takes (\d+) kB, five limbs take (\d+) kB more") == sizes


def test_memory_of_moves():
    example = move_store_bytes(21, 2, 1) - move_store_bytes(21, 1, 1)
    assert said("docs/moves.md", r"size: (\d+) kB .* 21 joints [\s\S]*?(\d\.\d) kB each") == [
        round(move_memory_bytes(21, 14) / 1000),
        round(example / 1000, 1),
    ]
