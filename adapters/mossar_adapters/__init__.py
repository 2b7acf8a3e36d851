"""Sources, sinks, file formats, sensors and engines around `mossar_stream`."""
