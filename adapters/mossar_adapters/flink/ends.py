"""Ends: where records come from and where events go, as Flink has it."""

import os
from collections.abc import Iterator

import msgspec
from pyflink.common import Row, Types, WatermarkStrategy
from pyflink.common.serialization import ByteArraySchema, Encoder, RowFieldExtractorSchema
from pyflink.datastream import DataStream, ProcessFunction, RuntimeContext, StreamExecutionEnvironment
from pyflink.datastream.connectors import DeliveryGuarantee
from pyflink.datastream.connectors.file_system import (
    FileSink,
    FileSource,
    OutputFileConfig,
    RollingPolicy,
    StreamFormat,
)
from pyflink.datastream.connectors.kafka import (
    KafkaOffsetResetStrategy,
    KafkaOffsetsInitializer,
    KafkaRecordSerializationSchema,
    KafkaSink,
    KafkaSource,
)

from mossar_adapters.address import parse_url
from mossar_adapters.flink import job as wanted
from mossar_adapters.flink.records import performer_of
from mossar_adapters.jsonlines import JsonLinesSink
from mossar_adapters.sink import Sink
from mossar_adapters.urls import open_sink
from mossar_stream import Event, MossarError

_event = msgspec.json.Decoder(Event)


def records(env: StreamExecutionEnvironment, source: wanted.Source) -> DataStream:
    """Return the stream of records.

    Raises:
        MossarError: If the Kafka connector is missing.
    """
    if source.kafka is not None:
        found, name = _kafka_source(source.kafka), f"topic {source.kafka.topic}"
    else:
        lines = StreamFormat.text_line_format()
        found, name = FileSource.for_record_stream_format(lines, source.files).build(), "files"
    return env.from_source(found, WatermarkStrategy.no_watermarks(), name)


def send(events: DataStream, to: wanted.Target, name: str) -> None:
    """Hand the events over.

    Args:
        events: JSON.
        to: Where.
        name: Of the job; identifies its transactions.

    Raises:
        MossarError: If the Kafka connector is missing.
    """
    if to.live is not None:
        # Not a sink of the engine's: those show events only at a checkpoint, or know no OSC and no ZeroMQ.
        events.process(SendFunction(to.live), Types.STRING()).name("live")
    elif to.kafka is not None:
        key_and_value = Types.ROW([Types.PRIMITIVE_ARRAY(Types.BYTE())] * 2)
        rows = events.map(lambda line: Row(performer_of(line).encode(), line.encode()), key_and_value)
        rows.sink_to(_kafka_sink(to.kafka, name)).name(f"topic {to.kafka.topic}")
    else:
        parts = OutputFileConfig.builder().with_part_prefix("events").with_part_suffix(".jsonl").build()
        sink = FileSink.for_row_format(to.files, Encoder.simple_string_encoder())
        policy = RollingPolicy.on_checkpoint_rolling_policy()
        built = sink.with_rolling_policy(policy).with_output_file_config(parts).build()
        events.sink_to(built).name("files")


class SendFunction(ProcessFunction):  # type: ignore[misc]  # it has no types
    """Sends each event at once; again after a failure.

    Args:
        url: As for `mossar run --to`.
    """

    def __init__(self, url: str) -> None:
        self._url = url

    def open(self, runtime_context: RuntimeContext) -> None:
        """Open the sink."""
        del runtime_context
        self._sink = _opened(self._url)

    def process_element(self, value: str, ctx: ProcessFunction.Context) -> Iterator[str]:
        """Send an event."""
        del ctx
        self._sink.send([_event.decode(value)])
        return iter(())

    def close(self) -> None:
        """Close the sink."""
        self._sink.close()


def _opened(url: str) -> Sink:
    address = parse_url(url)
    if address.scheme == "-":
        # The process's own: within the engine sys.stdout is a log.
        return JsonLinesSink(address, os.fdopen(os.dup(1), "wb"))
    return open_sink(url, force=True)  # a job that goes on after a failure opens it again


def _kafka_source(topic: wanted.KafkaSource) -> KafkaSource:
    begins = {
        "committed": lambda: KafkaOffsetsInitializer.committed_offsets(KafkaOffsetResetStrategy.EARLIEST),
        "earliest": KafkaOffsetsInitializer.earliest,
        "latest": KafkaOffsetsInitializer.latest,
    }
    try:
        return (
            KafkaSource.builder()
            .set_bootstrap_servers(topic.servers)
            .set_topics(topic.topic)
            .set_group_id(topic.group)
            .set_starting_offsets(begins[topic.begin]())
            .set_value_only_deserializer(ByteArraySchema())
            .set_properties(topic.properties)
            .build()
        )
    except TypeError:  # a class that the gateway does not have
        raise _no_connector() from None


def _kafka_sink(topic: wanted.KafkaTarget, name: str) -> KafkaSink:
    exactly = topic.guarantee == "exactly-once"
    try:
        schema = (
            KafkaRecordSerializationSchema.builder()
            .set_topic(topic.topic)
            .set_key_serialization_schema(RowFieldExtractorSchema(0))
            .set_value_serialization_schema(RowFieldExtractorSchema(1))
            .build()
        )
        builder = (
            KafkaSink.builder()
            .set_bootstrap_servers(topic.servers)
            .set_record_serializer(schema)
            .set_delivery_guarantee(
                DeliveryGuarantee.EXACTLY_ONCE if exactly else DeliveryGuarantee.AT_LEAST_ONCE
            )
            .set_transactional_id_prefix(name)
        )
        for key, value in topic.properties.items():
            builder.set_property(key, value)
        return builder.build()
    except TypeError:  # a class that the gateway does not have
        raise _no_connector() from None


def _no_connector() -> MossarError:
    return MossarError(
        "the Kafka connector is missing: put flink-sql-connector-kafka-VERSION.jar in Flink's lib folder, or name "
        'it as "pipeline.jars" = "file:///..." under [flink]'
    )
