"""Weights: found, checked, taken out of packages that lie there; what is said where they cannot be had."""

import hashlib
import zipfile

import msgspec
import pytest

from mossar_adapters.pose import weights as module
from mossar_adapters.pose.types import PoseError
from mossar_adapters.pose.weights import DETECTOR, MODELS, folder, kept, weights


@pytest.fixture
def models(tmp_path, monkeypatch):
    """Have the folder of the weights empty, and no network: the clients are given an index that does not answer."""
    monkeypatch.setenv("MOSSAR_MODELS", str(tmp_path / "models"))
    monkeypatch.setenv("PIP_INDEX_URL", "http://127.0.0.1:9/simple")
    monkeypatch.setenv("PIP_NO_CACHE_DIR", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", "")
    monkeypatch.setenv("PIP_EXTRA_INDEX_URL", "")
    monkeypatch.setenv("PIP_CONFIG_FILE", "/dev/null")
    monkeypatch.setenv("npm_config_registry", "http://127.0.0.1:9/")
    return tmp_path / "models"


@pytest.fixture
def known(monkeypatch):
    """Take two small files for the detector and the model full."""
    contents = {DETECTOR.member: b"detector", MODELS["full"].member: b"full"}

    def small(weight):
        return msgspec.structs.replace(weight, sha256=hashlib.sha256(contents[weight.member]).hexdigest())

    monkeypatch.setattr(module, "DETECTOR", small(DETECTOR))
    monkeypatch.setitem(module.MODELS, "full", small(MODELS["full"]))
    return contents


def wheel(place, contents):
    place.mkdir(exist_ok=True)
    path = place / "mediapipe-0.10.21-cp312-cp312-win_amd64.whl"
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in contents.items():
            archive.writestr(name, content)
    return path


def test_the_folder_is_the_one_that_the_environment_names(models):
    assert folder() == models


@pytest.mark.usefixtures("models")
def test_nothing_is_kept_in_an_empty_folder():
    assert kept() is None


def test_a_wheel_that_lies_there_is_unpacked_without_a_network(models, known):
    wheel(models, known)
    said = []
    found = weights(say=said.append)
    assert found.detector.read_bytes() == b"detector"
    assert found.landmarks.read_bytes() == b"full"
    assert said == []
    assert kept() == found
    assert sorted(path.name for path in models.glob("tmp*")) == []


def test_a_changed_file_is_not_used(models, known):
    wheel(models, known)
    found = weights()
    found.landmarks.write_bytes(b"else")
    assert kept() is None


def test_a_package_with_other_weights_is_refused(models, known):
    wheel(models, {**known, MODELS["full"].member: b"something else"})
    with pytest.raises(PoseError, match="SHA-256 differs"):
        weights()
    assert kept() is None


def test_a_damaged_package_is_refused(models, known):
    path = wheel(models, known)
    path.write_bytes(path.read_bytes()[:40])
    with pytest.raises(PoseError, match="cannot be taken out of it"):
        weights()


def test_without_a_network_one_command_is_named(models):
    said = []
    with pytest.raises(PoseError, match="mossar adapters --get-model") as error:
        weights(say=said.append)
    assert "\n" not in str(error.value)
    assert "36 MB" in said[0]
    assert "Apache-2.0" in said[0]
    assert str(models) in said[0]


def test_without_the_client_one_line_says_what_to_run(models, monkeypatch):
    monkeypatch.setenv("PATH", "")
    wheel(models, {DETECTOR.member: b""}).unlink()
    monkeypatch.setattr(module, "_is_whole", lambda _path, weight: weight is DETECTOR)
    with pytest.raises(
        PoseError, match=r"npm is not installed here; run: npm pack .* @mediapipe/pose@"
    ) as error:
        weights("lite")
    assert str(models) in str(error.value)


def test_a_folder_that_cannot_be_written_is_said(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("MOSSAR_MODELS", str(tmp_path / "file" / "models"))
    with pytest.raises(PoseError, match="weights cannot be kept there"):
        weights()
