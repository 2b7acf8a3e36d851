"""The moves that a performer is followed in: counts, progress and scores for the dashboard."""

from collections.abc import Mapping

from mossar_stream import Example, FollowEvent, FollowState, Moves, Skeleton, Up
from mossar_tools.dashboard.glimpse import FollowedMove, Overlay
from mossar_tools.dashboard.placement import Placement, Pose
from mossar_tools.dashboard.shadow import Shadow, seconds_of

States = Mapping[str, FollowState | None]


class FollowedMoves:
    """Collects states and events of followed moves; its size is bounded by the number of moves.

    Args:
        skeleton: Of the performer.
    """

    def __init__(self, skeleton: Skeleton) -> None:
        self._skeleton = skeleton
        self._moves: Moves | None = None
        self._up: Up = "auto"
        self._examples: list[Example] = []  # and mirror images
        self._shadow: Shadow | None = None
        self._states: States = {}
        # The last performance of each move in the take, the latest one last.
        self._done: dict[str, FollowEvent] = {}

    def add_event(self, event: FollowEvent) -> None:
        """Remember how a performance went."""
        if event.status == "done":
            self._done.pop(event.name, None)
            self._done[event.name] = event

    def begin_take(self) -> None:
        """Begin to count again."""
        self._done.clear()

    def take(self, states: States, moves: Moves | None, up: Up) -> None:
        """Set where the performer is in each followed move, the moves, and the axis that points upwards."""
        if moves is not self._moves or up != self._up:
            self._moves, self._up = moves, up
            self._examples = moves.examples_and_images(up) if moves is not None else []
            self._shadow = Shadow(moves.skeleton, self._skeleton) if moves is not None else None
        self._states = states
        for name in [name for name in self._done if name not in states]:
            del self._done[name]

    def ranked(self) -> list[FollowedMove]:
        """Return the moves that are followed: first the one that is most likely being made, else the one done last."""
        latest = {name: place for place, name in enumerate(self._done)}

        def rank(name: str) -> tuple[bool, float, int]:
            state = self._states[name]
            return state is not None, state.certainty if state else 0.0, latest.get(name, -1)

        return [self._followed_move(name) for name in sorted(self._states, key=rank, reverse=True)]

    def overlay(self, body: Pose, placement: Placement, now: float) -> Overlay | None:
        """Return the example of the first of `ranked` at the same place; None while it is not being made.

        Args:
            body: (J, 3) m, as `placement` places the performer.
            placement: Of the performer.
            now: s, when the performer was seen so.
        """
        first = next(iter(self.ranked()), None)
        state = self._states[first.name] if first is not None else None
        if state is None or self._moves is None or self._shadow is None:
            return None
        if not 0 <= state.example < len(self._examples):
            return None
        example = self._examples[state.example]
        length = max(seconds_of(example, self._moves.skeleton), 1e-3)
        # The state is of the last sample, the body of the last frame.
        ahead = min(max(now - state.time, 0.0), 0.2)
        place = state.progress + state.tempo * ahead / length
        joints = self._shadow.pose(example, place, body, placement)
        return Overlay(self._moves.skeleton, joints, self._shadow.strays(joints, body))

    def _followed_move(self, name: str) -> FollowedMove:
        state, done = self._states[name], self._done.get(name)
        score = done.score if done is not None else None
        count = done.count if done is not None else 0
        source: FollowState | FollowEvent | None = state or done
        if source is None:
            return FollowedMove(name)
        limb = max(source.limbs, key=lambda limb: source.limbs[limb], default="")
        angle = source.limbs.get(limb, source.deviation)
        progress = state.progress if state is not None else None
        return FollowedMove(name, max(count, source.count), progress, limb, angle, source.tempo, score)
