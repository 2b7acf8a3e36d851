"""A camera without a device: the genuine SDK measures synthetic depth pictures of the built-in performer on the host."""

import os
import sys
import threading
import time
from datetime import timedelta

import numpy as np
import pytest

from mossar_adapters.demo import performance
from mossar_adapters.oak.camera import Camera, Measurement
from mossar_adapters.oak.source import OakSource
from mossar_stream import Frames

os.environ.setdefault("DEPTHAI_LEVEL", "off")  # looked at when it is imported
try:
    import depthai as dai
except ImportError:
    dai = None

WIDTH, HEIGHT, FOCAL = 640, 352, 450.0  # pixels
BASELINE = 0.075  # m, of an OAK-D
SUBPIXELS = 8  # steps of disparity in a pixel
DISTANCE = 3.2  # m from the camera to the performer
WALL = 6.0  # m
DISC = 8  # pixels, the radius of a body part around its joint
FPS = 24.0
START = 1000.0  # s on the host's clock
DEPTH_STEP = DISTANCE**2 / (FOCAL * BASELINE) / SUBPIXELS  # m, 38 mm

OPEN = []  # stages of the test that runs


@pytest.fixture(scope="session")
def studio():
    """Return this module: the stage, and what is played on it."""
    if dai is None:
        pytest.skip("depthai is not installed: pip install 'mossar-stream[oak]'")
    if not hasattr(dai.node.SpatialLocationCalculator, "setRunOnHost"):
        pytest.skip(f"depthai {dai.__version__} measures no depth on the host")
    return sys.modules[__name__]


@pytest.fixture(autouse=True)
def _closed():
    """Close what a test that failed left open; see `Camera.close`."""
    yield
    while OPEN:
        OPEN.pop().camera.close()


class Stage:
    """A camera of the SDK without a device: synthetic pictures, genuine depth measurement, genuine queue.

    Args:
        noise: Standard deviation of the disparity in blocks of 8 by 8 pixels; it also comes in steps of 1/8 pixel.
        holes: Share of the blocks without depth.
        jitter: Standard deviation of the joints in the picture, pixels.
    """

    def __init__(self, noise=0.0, holes=0.0, jitter=0.0, unit="auto"):
        self.rng = np.random.default_rng(7)
        self.noise, self.holes, self.jitter = noise, holes, jitter
        pipeline = dai.Pipeline(False)
        measurement = Measurement(pipeline, FPS)
        # On a busy machine a queue of the usual 16 drops what is sent at once, before the measurement gets it.
        self.depth = measurement.depth.createInputQueue(maxSize=64)
        self.detections = measurement.people.createInputQueue()
        self.pipeline = pipeline
        self.camera = Camera(pipeline, measurement, name="stage", fps=FPS, unit=unit)
        OPEN.append(self)
        self.view = dai.ImgTransformation(
            WIDTH, HEIGHT, [[FOCAL, 0, WIDTH / 2], [0, FOCAL, HEIGHT / 2], [0, 0, 1]]
        )

    def send(self, number, seconds, people, confidence=None):
        """Show people, (17, 3) each in the axes of the source; hidden joints get little confidence."""
        seen = [project(joints) for joints in people]
        solid = draw(seen)
        detections = []
        for u, v, z in seen:
            sure = (
                np.where(hidden(solid, u, v, z), 0.2, 0.9) if confidence is None else np.full(17, confidence)
            )
            detections.append(self.detection(u + self.shake(), v + self.shake(), sure))
        self.send_depth(number, seconds, self.measured(solid))
        self.send_detections(number, seconds, detections)

    def shake(self):
        return self.rng.normal(0, self.jitter, 17) if self.jitter else 0.0

    def measured(self, solid):
        """Return what stereo makes of true depth, mm."""
        depth = solid.copy()
        blocks = (HEIGHT // 8, WIDTH // 8)
        if self.noise:
            disparity = FOCAL * BASELINE * 1000 / solid
            disparity += self.rng.normal(0, self.noise, blocks).repeat(8, 0).repeat(8, 1)
            depth = FOCAL * BASELINE * 1000 / np.maximum(np.round(disparity * SUBPIXELS), 1) * SUBPIXELS
        depth[(self.rng.random(blocks) < self.holes).repeat(8, 0).repeat(8, 1)] = 0
        return depth

    def detection(self, u, v, sure):
        found = dai.ImgDetection()
        found.setBoundingBox(dai.RotatedRect(dai.Rect(0.3, 0.1, 0.4, 0.8, True), 0))
        found.confidence = 0.9
        found.setKeypoints(
            [
                dai.Keypoint(dai.Point2f(float(x) / WIDTH, float(y) / HEIGHT), float(c))
                for x, y, c in zip(u, v, sure, strict=True)
            ]
        )
        return found

    def send_depth(self, number, seconds, depth):
        picture = dai.ImgFrame()
        picture.setType(dai.ImgFrame.Type.RAW16)
        picture.setWidth(WIDTH)
        picture.setHeight(HEIGHT)
        picture.setData(depth.astype(np.uint16).view(np.uint8).ravel())
        self.stamp(picture, number, seconds)
        self.depth.send(picture)

    def send_detections(self, number, seconds, detections):
        message = dai.ImgDetections()
        message.detections = detections
        self.stamp(message, number, seconds)
        self.detections.send(message)

    def stamp(self, message, number, seconds):
        message.setTransformation(self.view)
        message.setSequenceNum(number)
        message.setTimestamp(timedelta(seconds=seconds))


def project(joints):
    z = -joints[:, 2]
    return FOCAL * joints[:, 0] / z + WIDTH / 2, -FOCAL * joints[:, 1] / z + HEIGHT / 2, z


def draw(seen):
    """Return the depth picture of the body parts before the wall, (HEIGHT, WIDTH) mm."""
    solid = np.full((HEIGHT, WIDTH), WALL * 1000)
    rows, columns = np.ogrid[:HEIGHT, :WIDTH]
    for u, v, z in seen:
        for x, y, far in zip(u, v, z, strict=True):
            box = (
                slice(max(0, int(y) - DISC), int(y) + DISC + 1),
                slice(max(0, int(x) - DISC), int(x) + DISC + 1),
            )
            inside = (columns[:, box[1]] - int(x)) ** 2 + (rows[box[0]] - int(y)) ** 2 <= DISC**2
            part = solid[box]
            part[inside] = np.minimum(part[inside], far * 1000)
    return solid


def hidden(solid, u, v, z):
    x, y = np.clip(u, 0, WIDTH - 1).astype(int), np.clip(v, 0, HEIGHT - 1).astype(int)
    return solid[y, x] < z * 1000 - 60


def coco(take):
    """Return the 17 joints of COCO of the built-in performer, before the camera in the axes of the source."""
    skeleton, positions = take.skeleton, take.frames.positions.astype(float)
    at = {name: positions[:, skeleton.index(name)] for name in skeleton.names}
    left, up = unit(at["LeftUpperArm"] - at["RightUpperArm"]), unit(at["Head"] - at["Neck"])
    ahead = np.cross(left, up)
    face = ((0.1, 0, 0), (0.08, 0.03, 0.03), (0.08, -0.03, 0.03), (0, 0.075, 0), (0, -0.075, 0))
    joints = [at["Head"] + f * ahead + s * left + h * up for f, s, h in face]
    for part in ("UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot"):
        joints += [at[f"Left{part}"], at[f"Right{part}"]]
    body = np.stack(joints, axis=1)
    middle = body.mean((0, 1))
    return body - (middle[0], 1.0, middle[2] + DISTANCE)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def with_pelvis(body):
    return np.concatenate([body, body[:, 11:13].mean(1, keepdims=True)], axis=1)


def opened(camera):
    return lambda *_: camera


def await_received(source, count):
    """Wait until so many pictures arrived; the SDK drops some of those that are sent meanwhile."""
    limit = time.monotonic() + 5
    while source.counters.received < count and time.monotonic() < limit:
        time.sleep(0.0005)


def shown(stage, pictures, source=None):
    """Return what a source yields for pictures (number, seconds, people), each sent when the one before arrived."""
    source = source or OakSource(connect=opened(stage.camera))
    before = source.counters.received

    def feed():
        for count, picture in enumerate(pictures):
            stage.send(*picture)
            await_received(source, before + count + 1)

    feeder = threading.Thread(target=feed)
    feeder.start()
    found, fed = [], False
    for item in source.items():
        if item is None and fed:
            break
        found.append(item)
        # A picture is counted before its frames come: nothing must come for a while after it.
        fed = not feeder.is_alive()
    feeder.join()
    source.close()
    return source, [item for item in found if item is not None]


def frames_of(items, performer="p1"):
    return [item for item in items if isinstance(item, Frames) and item.performer == performer]


def standing():
    return coco(performance(seed=3, fps=FPS, seconds=1.0, moves=("rest:1",)))[0]
