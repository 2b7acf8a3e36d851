"""Pictures with a person that a package ships, and weights where they are on this machine."""

import numpy as np
import pytest

cv2 = pytest.importorskip("cv2", reason="the extra webcam is not installed")


@pytest.fixture(scope="session")
def weights():
    """Return the weights of the model `full`."""
    from mossar_adapters.pose.weights import kept

    pytest.importorskip("ai_edge_litert", reason="the extra webcam is not installed")
    found = kept()
    if found is None:
        pytest.skip("the weights are not here: mossar adapters --get-model")
    return found


@pytest.fixture(scope="session")
def astronaut():
    """Return a picture of a person, (512, 512, 3) BGR: Eileen Collins, by NASA, public domain."""
    data = pytest.importorskip("skimage.data", reason="scikit-image is not installed")
    return cv2.cvtColor(data.astronaut(), cv2.COLOR_RGB2BGR)


@pytest.fixture(scope="session")
def pan(astronaut):
    """Return a camera that pans to and fro over the person: 60 pictures of 480 x 480."""
    shifts = (32 * (1 - np.cos(2 * np.pi * np.arange(60) / 60)) / 2).astype(int)
    return [np.ascontiguousarray(astronaut[16:496, x : x + 480]) for x in shifts]


@pytest.fixture
def film(tmp_path):
    """Write pictures as a video and return its path."""

    def write(pictures, name="film.mp4", fps=30.0, codec=None):
        codec = codec or {"avi": "MJPG", "webm": "VP80"}.get(name.rpartition(".")[2], "mp4v")
        height, width = pictures[0].shape[:2]
        path = tmp_path / name
        writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*codec), fps, (width, height))
        assert writer.isOpened(), f"{codec} cannot be written here"
        for picture in pictures:
            writer.write(picture)
        writer.release()
        return path

    return write
