"""Reading and writing of noise.json, and reading of all our JSON files."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from calib.poses.imu_log import SI_UNIT, TRIADS
from pipeline.errors import UnreadableInput
from pipeline.results.schema.noise import (
    FORMAT,
    AxisNoiseResult,
    CoefficientResult,
    NoiseFile,
    TriadNoiseResult,
)

LARGEST_BYTES = 100_000_000  #: a session of a thousand poses has 2 MB


def read_json(path: Path, name: str, command: str) -> Any:
    """The contents of ``path``; ``name`` is how ``command`` calls the files that it writes.

    Raises
    ------
    UnreadableInput
        It is missing, larger than any that we write, or not JSON.
    """
    try:
        size = path.stat().st_size
        if size > LARGEST_BYTES:
            raise ValueError(f"{size} bytes, at most {LARGEST_BYTES} are expected")
        return json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UnreadableInput(
            f"{path}: cannot be read ({error.strerror}). Name the {name} that `{command}` has "
            f"written, or its folder."
        ) from error
    except (ValueError, RecursionError) as error:  # also where it is not UTF-8
        raise UnreadableInput(
            f"{path}: is not JSON ({error}). Name the {name} that `{command}` has written, or "
            f"write it anew with `{command}`."
        ) from error


NOISE_NAME = "noise.json"


def noise_json(log: str, rate_hz: float, length_s: float, triads: Mapping[str, Any]) -> str:
    """The text of a noise.json; ``triads`` maps names to the :class:`AxisNoise` of x, y, z."""
    parts = {name: TriadNoiseResult.of(unit=SI_UNIT[name], axes=[*map(_axis, triads[name])])
             if name in triads else None for name in TRIADS}
    contents = NoiseFile.of(format=FORMAT, log=log, rate_hz=rate_hz, length_s=length_s, **parts)
    return json.dumps(contents.as_json(), indent=1, ensure_ascii=False) + "\n"


def _axis(axis: Any) -> AxisNoiseResult:
    return AxisNoiseResult.of(axis.curve, **{
        name: CoefficientResult.of(coefficient, below=coefficient.limit)
        for name, coefficient in axis.coefficients.items()})


def load_noise(path: Path) -> NoiseFile:
    """Read a noise.json; ``path`` is the file or its folder.

    Raises
    ------
    UnreadableInput
        It is missing, or is none that `pipeline noise` has written.
    """
    path = path / NOISE_NAME if path.is_dir() else path
    contents = read_json(path, NOISE_NAME, "pipeline noise")
    try:
        return NoiseFile.parsed(contents)
    except ValueError as error:
        raise UnreadableInput(f"{path}: is not what `pipeline noise` writes ({error}). Write it "
                              f"anew.") from error
