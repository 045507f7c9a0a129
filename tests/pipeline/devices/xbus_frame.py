"""The bytes of a message of the Xsens protocol, by its manual (MT0100P, p. 26)."""


def frame(mid: int, data: bytes = b"") -> bytes:
    """Identifier and data between preamble and checksum; a LEN of FF is followed by two bytes."""
    length = len(data)
    size = bytes([length]) if length < 0xFF else bytes([0xFF, *length.to_bytes(2, "big")])
    body = bytes([0xFF, mid]) + size + data
    return bytes([0xFA]) + body + bytes([-sum(body) % 256])
