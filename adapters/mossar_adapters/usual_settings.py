"""Default settings for a kind of source."""

from collections.abc import Iterable, Mapping
from pathlib import PurePath

from mossar_adapters.address import parse_url


def usual_settings(sources: Iterable[str]) -> Mapping[str, object]:
    """Return the settings to lie under the user's own: of the first source whose kind has some.

    Args:
        sources: URLs and paths.

    Raises:
        SettingsError: If host, port or options of a URL cannot be read.

    Example:
        >>> sorted(usual_settings(["dance.mp4"]))
        ['one_euro_beta', 'one_euro_cutoff', 'smoothing']
        >>> usual_settings(["walk.bvh"])
        {}
    """
    for source in sources:
        address = parse_url(source)
        if address.scheme == "oak":
            from mossar_adapters.oak.source import DEFAULTS as OAK

            return OAK
        if address.scheme == "webcam" or (address.scheme == "file" and _is_of_pictures(address.path)):
            from mossar_adapters.pose.settings import DEFAULTS as POSE

            return POSE
    return {}


def _is_of_pictures(path: str) -> bool:
    """Return whether a path names a video, or the estimate that is kept beside one."""
    from mossar_adapters.files.registry import ESTIMATE_SUFFIX, VIDEO_SUFFIXES

    name = PurePath(path).name.lower()
    return name.endswith((*VIDEO_SUFFIXES, ESTIMATE_SUFFIX))
