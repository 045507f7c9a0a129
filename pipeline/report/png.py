"""Images inside the page: a small PNG as a ``data:`` address.

A frame of a clip is grey with a few coloured lines. As a palette of ``GREYS`` grey levels and a
coarse cube of colours it takes a fifth of the bytes of a true-colour PNG.
"""

import base64
import struct
import zlib

import numpy as np
from numpy.typing import NDArray

WIDEST = 480  #: pixels; a wider frame is reduced by a whole factor
GREYS = 40
LEVELS = 6  #: of each colour in the cube
COLOURED = 24  #: difference between a pixel's channels from which it is no grey
SIGNATURE = b"\x89PNG\r\n\x1a\n"


def image_address(bgr: NDArray[np.uint8]) -> str:
    """The ``data:`` address of an image (h, w, 3), blue-green-red."""
    return "data:image/png;base64," + base64.b64encode(png(_reduced(bgr))).decode("ascii")


def png(bgr: NDArray[np.uint8]) -> bytes:
    """An image (h, w, 3), blue-green-red, as a PNG with a palette."""
    index, palette = _indexed(bgr)
    height, width = index.shape
    # Every row begins with its filter; a palette's numbers are stored as they are (filter 0).
    rows = np.hstack([np.zeros((height, 1), np.uint8), index])
    header = struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)  # 8 bits, palette
    return b"".join([
        SIGNATURE,
        _chunk(b"IHDR", header),
        _chunk(b"PLTE", palette.tobytes()),
        _chunk(b"IDAT", zlib.compress(rows.tobytes(), 9)),
        _chunk(b"IEND", b""),
    ])  # fmt: skip


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _reduced(bgr: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The image as means of square blocks, not wider than ``WIDEST``."""
    by = -(-bgr.shape[1] // WIDEST)
    if by == 1:
        return bgr
    height, width = (size // by for size in bgr.shape[:2])
    blocks = bgr[: height * by, : width * by].reshape(height, by, width, by, 3)
    return np.asarray(blocks.mean(axis=(1, 3)).round().astype(np.uint8))


def _indexed(bgr: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Palette numbers (h, w) and the palette (GREYS + LEVELS³, 3), red-green-blue."""
    rgb = bgr[:, :, ::-1].astype(int)
    coloured = np.ptp(rgb, axis=2) >= COLOURED
    grey = (rgb.mean(axis=2) / 255 * (GREYS - 1)).round().astype(int)
    r, g, b = np.moveaxis((rgb / 255 * (LEVELS - 1)).round().astype(int), 2, 0)
    index = np.where(coloured, GREYS + (r * LEVELS + g) * LEVELS + b, grey)
    greys = np.repeat(np.linspace(0, 255, GREYS)[:, None], 3, axis=1)
    steps = np.linspace(0, 255, LEVELS)
    cube = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    palette = np.concatenate([greys, cube]).round().astype(np.uint8)
    return index.astype(np.uint8), palette
