"""The cache of phase tracks: tracking a clip is the slow part of a run, and clips do not change.

A track's key is the SHA-256 of the clip's bytes, of the settings it was tracked with and of
``TRACK_FORMAT``. A damaged, foreign or edited file is never used, which a digest at its beginning
ensures; the clip is tracked anew.
"""

import hashlib
import io
import json
import zipfile
from collections.abc import Callable
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import UnreadableInput
from pipeline.files import may_never_end, write_whole
from vision.geometry import PlateOverride
from vision.phase_track import PhaseTrack, PlateLayout

#: Raise it whenever :func:`vision.tracking.track.track_phase` gives other numbers than before.
TRACK_FORMAT = 23

DIGEST_BYTES = hashlib.sha256().digest_size  #: before the arrays: a file that was edited is damaged

Follow = Callable[[], PhaseTrack]


def track_key(clip: Path, plate: PlateOverride | None, from_s: float = 0.0) -> str:
    """Name under which the track of ``clip``, learned from ``from_s`` on, is stored.

    Raises
    ------
    UnreadableInput
        The clip cannot be read.
    """
    settings = {"format": TRACK_FORMAT, "plate": None if plate is None else asdict(plate),
                "from_s": from_s}
    digest = hashlib.sha256(json.dumps(settings, sort_keys=True).encode())
    try:
        if may_never_end(clip):
            raise UnreadableInput(f"{clip}: is a pipe or a device; a clip is expected.")
        with clip.open("rb") as file:
            while block := file.read(1 << 20):
                digest.update(block)
    except OSError as error:
        raise UnreadableInput(
            f"{clip}: the clip cannot be read ({error.strerror}). Check the name, and that you "
            f"may read the file."
        ) from error
    return digest.hexdigest()


def kept_track(cache: Path, key: str, follow: Follow) -> PhaseTrack:
    """The track under ``key``; if there is none, it is computed by ``follow`` and stored."""
    path = cache / f"{key}.npz"
    kept = _load(path)
    if kept is not None:
        return kept
    track = follow()
    write_whole(path, _packed(track))
    return track


def _packed(track: PhaseTrack) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **plain_arrays(track))  # type: ignore[arg-type]
    data = buffer.getvalue()
    return hashlib.sha256(data).digest() + data


def plain_arrays(track: PhaseTrack) -> dict[str, NDArray[Any]]:
    """Every field of a track as an array, those of its plate as ``plate.NAME``."""
    arrays = {
        field.name: np.asarray(getattr(track, field.name))
        for field in fields(track) if field.name != "plate"
    }
    for field in fields(track.plate):
        arrays[f"plate.{field.name}"] = np.asarray(getattr(track.plate, field.name))
    return arrays


def _load(path: Path) -> PhaseTrack | None:
    """The track in ``path``; None where it is missing or is not a whole track."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    digest, data = content[:DIGEST_BYTES], content[DIGEST_BYTES:]
    if hashlib.sha256(data).digest() != digest:
        return None
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as stored:
            plate = {field.name: stored[f"plate.{field.name}"] for field in fields(PlateLayout)}
            values = {
                field.name: stored[field.name]
                for field in fields(PhaseTrack) if field.name != "plate"
            }
    except (ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    size_px = tuple(int(size) for size in plate["size_px"])
    layout = PlateLayout(**{**plate, **_scalars(plate), "size_px": size_px})
    notes = tuple(str(note) for note in values["notes"])
    return PhaseTrack(**{**values, **_scalars(values), "notes": notes, "plate": layout})


def _scalars(values: dict[str, NDArray[Any]]) -> dict[str, Any]:
    return {name: value.item() for name, value in values.items() if value.ndim == 0}
