"""Methods: everything that is compared, in the order of the table."""

from mossar_stream import Settings
from mossar_tools.evaluation.chance import chance_methods
from mossar_tools.evaluation.found import Method
from mossar_tools.evaluation.mossar import mossar_methods
from mossar_tools.evaluation.recursion import li_and_leung
from mossar_tools.evaluation.velocity_based import velocity_based

RIVAL_EDGES = 40  # N of Li and Leung's method, which needs many


def all_methods(settings: Settings) -> list[Method]:
    """Return Mossar by parts and similarities, its two rivals of the paper, and chance.

    Args:
        settings: Of all that is Mossar; the level is that of each take.
    """
    return [
        *mossar_methods(settings),
        velocity_based(settings),
        li_and_leung(settings.replace(edges=RIVAL_EDGES)),
        *chance_methods(settings),
    ]
