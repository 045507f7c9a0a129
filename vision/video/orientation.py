"""Rotation and mirroring of the frames of a file for display.

A phone writes the frames in its sensor's orientation, with a matrix in the header of the track that
maps a point (x, y) of the stored frame to the displayed one (ISO 14496-12, 8.3.2),

    (x', y') = (a x + c y, b x + d y)   up to a shift.

Eight of them map pixels to pixels: four rotations, each with and without a mirror. OpenCV
supports the rotations only, and an overlooked mirror reverses the sense of rotation.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import cv2
import numpy as np
from numpy.typing import NDArray

# Bytes from the start of a header's content to its matrix, by the version of the header.
TRACK_MATRIX = {0: 40, 1: 52}
MOVIE_MATRIX = {0: 36, 1: 48}  #: bytes to the matrix of `mvhd` by its version; ISO 14496-12
HANDLER = slice(8, 12)  #: bytes of `hdlr` that name the kind of track; ISO 14496-12
#: Bytes; a day at 1000 frames per second has an index of half of it.
LONGEST_MOVIE = 1 << 30


@dataclass(frozen=True)
class Orientation:
    """Orientation of frames: first transposed, then flipped.

    Parameters
    ----------
    transposed : bool
        Rows become columns.
    left_right, up_down : bool
        Flips after that.
    """

    transposed: bool = False
    left_right: bool = False
    up_down: bool = False

    @property
    def mirrored(self) -> bool:
        """Whether the displayed sense of rotation is opposite to that of the stored frames."""
        return self.transposed ^ self.left_right ^ self.up_down

    def displayed(self, image: NDArray[Any]) -> NDArray[Any]:
        """The frame (h, w, ...) in display orientation; transposed it is (w, h, ...)."""
        if self.transposed:
            image = np.asarray(cv2.transpose(image))
        if self.left_right or self.up_down:
            around = -1 if self.left_right and self.up_down else int(self.left_right)
            image = np.asarray(cv2.flip(image, around))
        return image


def stated_orientation(path: Path) -> Orientation | None:
    """Orientation of the first video track of an MP4 or MOV file; None for any other file."""
    with path.open("rb") as file:
        movie = _movie(file, path.stat().st_size)
    turn = np.eye(2)
    for kind, content in _boxes(movie):
        if kind == b"mvhd":
            turn = _matrix(content, MOVIE_MATRIX)
        if kind == b"trak" and (track := _video_track(content)) is not None:
            return _orientation(_matrix(track, TRACK_MATRIX) @ turn)
    return None


def _movie(file: BinaryIO, length: int) -> bytes:
    """Content of the box 'moov' of a file of ``length`` bytes, empty without one.

    A stream without boxes, as a Raspberry Pi writes it, may state any size: a box must end inside
    the file.
    """
    while len(head := file.read(8)) == 8:
        size, kind = struct.unpack(">I4s", head)
        header = 8
        if size == 1 and len(long := file.read(8)) == 8:
            size, header = int.from_bytes(long), 16
        content = size - header
        if content < 0 or content > length - file.tell():
            break  # a size of 0 means up to the end of the file; others are not a box
        if kind == b"moov":
            return file.read(content) if content <= LONGEST_MOVIE else b""
        file.seek(content, 1)
    return b""


def _boxes(content: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Kind and content of each box in the content of another."""
    at = 0
    while at + 8 <= len(content):
        size, kind = struct.unpack_from(">I4s", content, at)
        if size < 8:
            return
        yield kind, content[at + 8 : at + size]
        at += size


def _video_track(track: bytes) -> bytes | None:
    """The header of a video track."""
    parts = dict(_boxes(track))
    handler = dict(_boxes(parts.get(b"mdia", b""))).get(b"hdlr", b"")
    return parts.get(b"tkhd") if handler[HANDLER] == b"vide" else None


def _matrix(header: bytes, places: dict[int, int]) -> NDArray[np.float64]:
    """((a, b), (c, d)) of a header, zeros if it is truncated or of another version."""
    at = places.get(header[0], len(header)) if header else 0
    if at + 20 > len(header):
        return np.zeros((2, 2))
    a, b, _, c, d = struct.unpack_from(">5i", header, at)
    return np.array([[a, b], [c, d]]) / (1 << 16)


def _orientation(matrix: NDArray[np.float64]) -> Orientation | None:
    """The orientation of a matrix; None if pixels do not map to pixels."""
    (a, b), (c, d) = matrix
    if a and d and not b and not c:
        return Orientation(False, bool(a < 0), bool(d < 0))
    if b and c and not a and not d:
        return Orientation(True, bool(c < 0), bool(b < 0))
    return None
