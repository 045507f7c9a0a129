"""The names of the protocols that ``pipeline playback`` speaks, without anything to import."""

#: As :data:`pipeline.playback.device.PROTOCOLS`, in the same order.
PROTOCOL_NAMES = ("xsens-mti", "sketch", "a/g", "binary")
