"""The page of `mossar webcam`: the browser's camera as a sensor, estimated in the browser."""
