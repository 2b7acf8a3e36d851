"""The bundle that the maker's landmarker for browsers takes, made of the two networks.

A `.task` is a zip archive, stored, of the detector and the landmarks. Each carries TFLite metadata, with the scaling of
pixels; without them the landmarker refuses it. They are a FlatBuffer of the schema
`metadata_schema.fbs`, appended to the network as a buffer of the name TFLITE_METADATA.
"""

import io
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np

from mossar_adapters.extras import needed
from mossar_adapters.pose.weights import Weights

# Range of (pixel - mean) / deviation: -1 to 1 for the detector, 0 to 1 for the landmarks.
_DETECTOR: Final = (127.5, 127.5)
_LANDMARKS: Final = (0.0, 255.0)
# Of metadata_schema.fbs: kinds in unions, numbers of fields in tables.
_NORMALISATION: Final = 1  # ProcessUnitOptions.NormalizationOptions
_IMAGE: Final = 2  # ContentProperties.ImageProperties
_RGB: Final = 1  # ColorSpaceType.RGB
_NAME: Final = b"TFLITE_METADATA"


def write_task(weights: Weights, path: Path) -> None:
    """Write the bundle of a detector and of landmarks.

    Args:
        weights: The two networks.
        path: Of the bundle; replaced in one go.
    """
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_STORED) as bundle:
        bundle.writestr("pose_detector.tflite", _described(weights.detector, *_DETECTOR))
        bundle.writestr("pose_landmarks_detector.tflite", _described(weights.landmarks, *_LANDMARKS))
    temporary = path.with_suffix(".new")
    temporary.write_bytes(content.getvalue())
    temporary.replace(path)


def _described(path: Path, mean: float, deviation: float) -> bytes:
    """Return a network with metadata of the scaling of its pixels."""
    needed("ai_edge_litert", "webcam", "the camera of the browser (webcam:browser)")
    import flatbuffers
    from ai_edge_litert import schema_py_generated as schema

    model = schema.ModelT.InitFromObj(schema.Model.GetRootAsModel(path.read_bytes(), 0))
    buffer, metadata = schema.BufferT(), schema.MetadataT()
    buffer.data = np.frombuffer(_metadata(mean, deviation), np.uint8)
    metadata.name, metadata.buffer = _NAME, len(model.buffers)
    model.buffers.append(buffer)
    model.metadata = [*(model.metadata or []), metadata]
    builder = flatbuffers.Builder(path.stat().st_size)
    builder.Finish(model.Pack(builder), b"TFL3")
    return bytes(builder.Output())


def _metadata(mean: float, deviation: float) -> bytes:
    """Return `ModelMetadata` of a network that takes one RGB picture."""
    import flatbuffers

    build = flatbuffers.Builder(512)

    def table(fields: int, *steps: Callable[[], None]) -> int:
        build.StartObject(fields)
        for step in steps:
            step()
        return int(build.EndObject())

    def refer(field: int, to: int) -> Callable[[], None]:
        return lambda: build.PrependUOffsetTRelativeSlot(field, to, 0)

    def kind(field: int, value: int) -> Callable[[], None]:
        return lambda: build.PrependUint8Slot(field, value, 0)

    means, deviations = _floats(build, mean), _floats(build, deviation)
    options = table(2, refer(0, means), refer(1, deviations))  # NormalizationOptions
    unit = table(2, kind(0, _NORMALISATION), refer(1, options))  # ProcessUnit
    image = table(2, lambda: build.PrependInt8Slot(0, _RGB, 0))  # ImageProperties
    content = table(3, kind(0, _IMAGE), refer(1, image))  # Content
    name, units = build.CreateString("image"), _list(build, unit)
    tensor = table(7, refer(0, name), refer(3, content), refer(4, units))  # TensorMetadata
    inputs = _list(build, tensor)
    graphs = _list(build, table(9, refer(2, inputs)))  # SubGraphMetadata
    model, version = build.CreateString("pose"), build.CreateString("1.0.0")
    build.Finish(table(8, refer(0, model), refer(3, graphs), refer(7, version)), b"M001")  # ModelMetadata
    return bytes(build.Output())


def _floats(build: Any, value: float) -> int:
    build.StartVector(4, 1, 4)
    build.PrependFloat32(value)
    return int(build.EndVector())


def _list(build: Any, item: int) -> int:
    build.StartVector(4, 1, 4)
    build.PrependUOffsetTRelative(item)
    return int(build.EndVector())
