"""Scene: bodies in three dimensions, the last key poses as ghosts on a line beside them."""

from collections.abc import Callable, Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle, ViserServer

from mossar_stream import Skeleton
from mossar_tools.dashboard.figures import Solids, ball_mesh, balls_of, bone_mesh, bones_of, joined
from mossar_tools.dashboard.framing import FIELD, FRONT, USUAL, Size, framed, window_of
from mossar_tools.dashboard.glimpse import Ghost, Glimpse, Overlay
from mossar_tools.dashboard.style import rgb
from mossar_tools.dashboard.track import GHOSTS
from mossar_tools.palette import Palette

STEP = 0.88  # m between two ghosts
_MARGIN = 1.9  # m for the live body

_WINDOWS = 16  # whose sizes are remembered
NEAR, FAR = 8.0, 30.0  # degrees, from which a bone that strays gets colour, and from which it has all of it
SEEN_THROUGH = 0.3  # opacity of the example over the body
# So much larger are the example's bones (across, across, along) and balls, so that it stays seen around the body.
AROUND = np.array([[1.35, 1.35, 1.0], [1.15, 1.15, 1.15]], np.float32)
_FADED = 0.35  # opacity of the oldest ghost, as a share of the latest's

Colours = NDArray[np.uint8]


class Scene:
    """Draws performers into a viser scene, and sends changes only.

    Args:
        server: The page's server.
        palette: Colours.
        visit: Called with the time of a ghost that is clicked; None if they cannot be.
    """

    def __init__(
        self, server: ViserServer, palette: Palette, visit: Callable[[float], None] | None = None
    ) -> None:
        self._server = server
        self._visit = visit
        self._figures: list[_Figure] = []
        self._room = (1, GHOSTS)  # performers, and ghosts of each
        self._windows: list[Size] = []  # px, the latest last
        self._aimed: dict[int, tuple[Size, Size]] = {}  # picture and window of each client
        server.scene.set_up_direction("+z")
        server.initial_camera.fov = FIELD
        server.initial_camera.position, server.initial_camera.look_at = self._framed(USUAL)
        server.on_client_connect(self._on_connect)
        server.on_client_disconnect(self._on_disconnect)
        self.paint(palette)

    def paint(self, palette: Palette) -> None:
        """Take other colours."""
        self._palette = palette
        self._server.scene.add_grid(
            "/ground",
            infinite_grid=True,
            cell_size=0.5,
            section_size=2.0,
            cell_color=rgb(palette.faint),
            section_color=rgb(palette.faint),
            section_thickness=1.4,
            cell_thickness=0.7,
            fade_distance=26.0,
            fade_from="origin",
            shadow_opacity=0.18,
        )
        for figure in self._figures:
            figure.paint(palette)

    def draw(self, glimpses: list[Glimpse]) -> None:
        """Show performers side by side."""
        if [figure.skeleton for figure in self._figures] != [glimpse.skeleton for glimpse in glimpses]:
            self._lay_out(glimpses)
        for figure, glimpse in zip(self._figures, glimpses, strict=True):
            figure.draw(glimpse)

    def _lay_out(self, glimpses: list[Glimpse]) -> None:
        for figure in self._figures:
            figure.remove()
        count = len(glimpses)
        ghosts = max(2, GHOSTS // max(count, 1))
        width = ghosts * STEP + _MARGIN
        self._figures = []
        for i, glimpse in enumerate(glimpses):
            right = (i + 1 - count / 2) * width
            figure = _Figure(self._server, f"/figures/{i}", glimpse, right, ghosts, named=count > 1)
            if self._visit is not None:
                figure.go_to(self._visit)
            self._figures.append(figure)
            self._figures[-1].paint(self._palette)
        if count:
            self._room = (count, ghosts)
            self._aimed.clear()
            self._aim_all()

    def know_window(self, size: Size) -> None:
        """Note the size of a window, px."""
        if self._windows[-1:] != [size]:
            self._windows = [*(known for known in self._windows if known != size), size][-_WINDOWS:]
            self._aim_all()

    def _framed(self, window: Size) -> Any:
        """Return the place of the camera in a window, and the point that it looks at."""
        count, ghosts = self._room
        width = count * (ghosts * STEP + _MARGIN)
        needed = _MARGIN + 2 * STEP if count == 1 else width
        return framed(window, width, needed, whole_take=self._visit is not None)

    async def _on_connect(self, client: ClientHandle) -> None:
        """Aim the camera of a new window, and again whenever its size changes."""
        client.camera.on_update(lambda _: self._aim(client))
        self._aim(client)

    def _on_disconnect(self, client: ClientHandle) -> None:
        self._aimed.pop(client.client_id, None)

    def _aim_all(self) -> None:
        for client in self._server.get_clients().values():
            self._aim(client)

    def _aim(self, client: ClientHandle) -> None:
        """Aim a camera, unless that has been done for this size: people may have moved it since."""
        picture = (client.camera.image_width, client.camera.image_height)
        window = window_of(picture, self._windows)
        if self._aimed.get(client.client_id) != (picture, window):
            self._aimed[client.client_id] = (picture, window)
            client.camera.position, client.camera.look_at = self._framed(window)


class _Figure:
    """One performer: the live body at the right end, ghosts to its left."""

    def __init__(
        self,
        server: ViserServer,
        name: str,
        glimpse: Glimpse,
        right: float,
        ghosts: int,
        *,
        named: bool,
    ) -> None:
        self.skeleton = glimpse.skeleton
        self._scene = server.scene
        self._name = name
        self._spot = np.array([right - _MARGIN / 2, -FRONT, 0.0], np.float32)
        self._first = right - _MARGIN - (ghosts - 0.5) * STEP  # of the oldest ghost
        self._room = ghosts
        self._shown: object = None  # the drawn ghosts
        self._ghosts: list[Ghost] = []
        self._nodes: list[Any] = []
        self._over: list[Any] = []  # the example over the body: its bones and its balls
        self._over_of: Skeleton | None = None  # skeleton that they are of
        empty = np.full((len(glimpse.skeleton), 3), np.nan, np.float32)
        self._bones = self._add("bones", bone_mesh(), bones_of(glimpse.skeleton, empty))
        self._balls = self._add("balls", ball_mesh(), balls_of(glimpse.skeleton, empty))
        many, fading = [empty] * ghosts, 0.75 * np.linspace(_FADED, 1.0, ghosts)
        self._ghost_bones = self._add(
            "ghost bones", bone_mesh(), joined([bones_of(glimpse.skeleton, e) for e in many]), fading
        )
        self._ghost_balls = self._add(
            "ghost balls", ball_mesh(), joined([balls_of(glimpse.skeleton, e) for e in many]), fading
        )
        self._label("name", f"{glimpse.performer} now" if named else "now", self._spot, 1.0)
        self._labels = [self._label(f"time {i}", " ", self._place(i), 0.8) for i in range(ghosts)]

    def paint(self, palette: Palette) -> None:
        """Take other colours."""
        self._calm = np.array(rgb(palette.ink), np.float32)  # the lights make all colours paler
        self._lively = np.array(rgb(palette.moving), np.float32)
        self._straying = np.array(rgb(palette.level), np.float32)
        self._example = np.array(rgb(palette.minimum), np.uint8)
        self._kinds = {kind: rgb(getattr(palette, kind)) for kind in ("onset", "offset", "minimum")}
        self._shown = None

    def draw(self, glimpse: Glimpse) -> None:
        """Show the body and its ghosts."""
        if glimpse.body is not None:
            motion = glimpse.body.motion
            self._draw_overlay(glimpse.overlay)
            joints = glimpse.body.joints + self._spot
            pairs = np.array(self.skeleton.bones(), np.intp).reshape(-1, 2)
            shares, still = motion[pairs].mean(axis=1), motion
            colour = self._lively
            if glimpse.overlay is not None:
                shares, still, colour = straying(glimpse.overlay.strays), 0 * motion, self._straying
            bones, balls = self._mixed(shares, colour), self._mixed(still, colour)
            _update(self._bones, bones_of(self.skeleton, joints), bones)
            _update(self._balls, balls_of(self.skeleton, joints), balls)
        ghosts = glimpse.ghosts[-self._room :]
        key = [(ghost.mark.id, ghost.mark.time, ghost.mark.decided) for ghost in ghosts]
        if key != self._shown and ghosts:
            self._shown, self._ghosts = key, ghosts
            self._draw_ghosts(ghosts)

    def go_to(self, visit: Callable[[float], None]) -> None:
        """Have a click on a ghost go to its time."""

        async def clicked(event: Any) -> None:
            time = self._time_at(event.ray_origin, event.ray_direction)
            if time is not None:
                visit(time)

        for node in (self._ghost_bones, self._ghost_balls):
            node.on_click(clicked)

    def _time_at(self, origin: Any, direction: Any) -> float | None:
        """Return the time of the ghost that a line of sight meets."""
        if abs(direction[1]) < 1e-9:
            return None
        x = origin[0] - direction[0] * origin[1] / direction[1]  # where it meets the ghosts' plane
        i = round((x - self._first) / STEP) - (self._room - len(self._ghosts))
        return self._ghosts[i].mark.time if 0 <= i < len(self._ghosts) else None

    def remove(self) -> None:
        """Take everything away."""
        for node in self._nodes:
            node.remove()

    def _mixed(self, shares: NDArray[np.float32], colour: NDArray[np.float32]) -> Colours:
        return (self._calm + shares[:, None] * (colour - self._calm)).astype(np.uint8)

    def _draw_overlay(self, overlay: Overlay | None) -> None:
        """Show the example over the body, or nothing."""
        if overlay is None:
            for node in self._over:
                node.visible = False
            return
        joints = overlay.joints + self._spot
        solids = [bones_of(overlay.skeleton, joints), balls_of(overlay.skeleton, joints)]
        solids = [
            msgspec.structs.replace(one, sizes=one.sizes * around)
            for one, around in zip(solids, AROUND, strict=True)
        ]
        if self._over_of != overlay.skeleton:
            for node in self._over:
                self._nodes.remove(node)
                node.remove()
            self._over_of = overlay.skeleton
            meshes = (("over bones", bone_mesh()), ("over balls", ball_mesh()))
            self._over = [
                self._add(name, mesh, parts, (SEEN_THROUGH,))
                for (name, mesh), parts in zip(meshes, solids, strict=True)
            ]
        for node, parts in zip(self._over, solids, strict=True):
            _update(node, parts, np.tile(self._example, (len(parts.places), 1)))
            node.visible = True

    def _draw_ghosts(self, ghosts: list[Ghost]) -> None:
        empty = np.full((len(self.skeleton), 3), np.nan, np.float32)
        free = self._room - len(ghosts)  # at the left end
        places = [empty] * free
        places += [ghost.joints + self._place(free + i) for i, ghost in enumerate(ghosts)]
        colours = [(0, 0, 0)] * free + [self._kinds[ghost.mark.kind] for ghost in ghosts]
        bones = [bones_of(self.skeleton, place) for place in places]
        balls = [balls_of(self.skeleton, place) for place in places]
        _update(self._ghost_bones, joined(bones), _repeated(colours, len(self.skeleton.bones())))
        _update(self._ghost_balls, joined(balls), _repeated(colours, len(self.skeleton)))
        words = [f"{ghost.mark.kind}\n{ghost.mark.time:.1f} s" for ghost in ghosts]
        for label, text in zip(self._labels, [""] * free + words, strict=True):
            label.text, label.visible = text or " ", bool(text)

    def _place(self, i: int) -> NDArray[np.float32]:
        return np.array([self._first + i * STEP, 0.0, 0.0], np.float32)

    def _label(self, name: str, text: str, spot: NDArray[np.float32], size: float) -> Any:
        label = self._scene.add_label(
            f"{self._name}/{name}",
            text,
            position=spot + np.array([0.0, -0.25, -0.02]),
            anchor="top-center",
            font_screen_scale=size,
        )
        self._nodes.append(label)
        return label

    def _add(
        self,
        name: str,
        mesh: tuple[NDArray[np.float32], NDArray[np.uint32]],
        solids: Solids,
        fading: Sequence[float] | NDArray[np.float64] = (1.0,),
    ) -> Any:
        """Add copies of a mesh, as many for each opacity of `fading`; transparent ones cast no shadow."""
        node = self._scene.add_batched_meshes_simple(
            f"{self._name}/{name}",
            mesh[0],
            mesh[1],
            solids.turns,
            solids.places,
            batched_scales=solids.sizes,
            batched_colors=np.zeros((len(solids.places), 3), np.uint8),
            batched_opacities=np.repeat(fading, len(solids.places) // len(fading)),
            lod="off",
            cast_shadow=fading[0] == 1,
            receive_shadow=False,
        )
        self._nodes.append(node)
        return node


def straying(angles: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the share of the colour of each bone, 0 to 1, for the angle by which it strays, degrees."""
    shares = (np.nan_to_num(angles) - NEAR) / (FAR - NEAR)
    return np.asarray(np.clip(shares, 0.0, 1.0), np.float32)


def _update(node: Any, solids: Solids, colours: Colours) -> None:
    node.batched_positions = solids.places
    node.batched_wxyzs = solids.turns
    node.batched_scales = solids.sizes
    node.batched_colors = colours


def _repeated(colours: list[tuple[int, int, int]], count: int) -> Colours:
    return np.repeat(np.array(colours, np.uint8), count, axis=0)
