"""noise.json written and read back, as every JSON file of ours."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
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
from pipeline.results.schema.types import problems_of

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
        text = path.read_text(encoding="utf-8") if size <= LARGEST_BYTES else None
    except OSError as error:
        raise UnreadableInput(
            f"{path}: cannot be read ({error.strerror}). Name the {name} that `{command}` has "
            f"written, or its folder."
        ) from error
    except ValueError as error:  # not UTF-8
        raise _not_json(path, str(error), name, command) from error
    if text is None:
        problem = f"{size} bytes, at most {LARGEST_BYTES} are expected"
        raise _not_json(path, problem, name, command)
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise _not_json(path, str(error), name, command) from error


def _not_json(path: Path, problem: str, name: str, command: str) -> UnreadableInput:
    return UnreadableInput(
        f"{path}: is not JSON ({problem}). Name the {name} that `{command}` has written, or write "
        f"it anew with `{command}`."
    )


NOISE_NAME = "noise.json"


@dataclass(frozen=True)
class StoredNoise:
    """What Kalibr and OpenVINS take from a noise.json: continuous-time values of each triad.

    ``density`` and ``random_walk`` by triad are root mean squares over the axes; those in
    ``limits`` are upper limits, because the log does not show them.
    """

    path: Path
    rate_hz: float
    density: Mapping[str, float]
    random_walk: Mapping[str, float]
    limits: tuple[str, ...]


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


def load_noise(path: Path) -> StoredNoise:
    """Read a noise.json; ``path`` is the file or its folder.

    Raises
    ------
    UnreadableInput
        It is missing, or is none that `pipeline noise` has written.
    """
    path = path / NOISE_NAME if path.is_dir() else path
    contents = read_json(path, NOISE_NAME, "pipeline noise")
    if problems := problems_of(NoiseFile, contents):
        raise UnreadableInput(f"{path}: is not what `pipeline noise` writes ({problems}). Write it "
                              f"anew.")
    density: dict[str, float] = {}
    walk: dict[str, float] = {}
    limits: list[str] = []
    for name in TRIADS:
        if contents[name] is None:
            continue
        for key, target in (("noise_density", density), ("random_walk", walk)):
            axes = [axis[key] for axis in contents[name]["axes"]]
            if any(axis["value"] is None for axis in axes):
                limits.append(f"{name}_{key}")
            values = [axis["below"] if axis["value"] is None else axis["value"] for axis in axes]
            target[name] = math.sqrt(sum(value**2 for value in values) / len(values))
    return StoredNoise(path, contents["rate_hz"], density, walk, tuple(limits))
