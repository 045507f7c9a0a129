"""Formats of robotics: Kalibr (and OpenVINS, which reads the same keys), and ROS imu_calib.

Kalibr states the forward model of what a driver publishes in SI units by the data sheet,

    accelerometer   y = M_a f + b_a
    gyroscope       y = M_g C w + A C f + b_g

with M lower triangular and C from the body to the gyroscope's frame, which turns the specific force
too (``IccScaledMisalignedImu.addGyroscopeErrorTerms`` of Kalibr). Ours is the inverse,
``s = T K (u - b)`` with T upper triangular, in frames that magnitudes leave open; in nominal
readings ``y = k0 (u - b0)`` it says ``y = N s + k0 (b - b0)`` with ``N = k0 (T K)⁻¹``, upper
triangular too. The decomposition ``N = L Q``, L lower triangular and Q a rotation, makes M = L, and
turns the frame: the body of the file is ``Q_a`` times the accelerometer's frame here.
"""

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from calib.poses.imu_log import FloatArray
from pipeline.export.parts import (
    Export,
    example_text,
    no_effects,
    no_sds,
    origin,
    triad_named,
)
from pipeline.results.read import Stored, StoredTriad
from pipeline.results.schema.noise import NoiseFile

NOISE_KEYS = (
    "accelerometer_noise_density", "accelerometer_random_walk",
    "gyroscope_noise_density", "gyroscope_random_walk",
)  # fmt: skip
NOISE_UNITS = {
    "accelerometer_noise_density": "m/s^2/sqrt(Hz)", "accelerometer_random_walk": "m/s^3/sqrt(Hz)",
    "gyroscope_noise_density": "rad/s/sqrt(Hz)", "gyroscope_random_walk": "rad/s^2/sqrt(Hz)",
    "update_rate": "Hz",
}


def lower_and_rotation(square: FloatArray) -> tuple[FloatArray, FloatArray]:
    """L, lower triangular with a positive diagonal, and Q of ``square = L Q``, each (3, 3).

    Q is a rotation where the determinant of ``square`` is positive; L is in its unit.
    """
    q, r = np.linalg.qr(square.T)
    sign = np.sign(np.diag(r))
    return np.asarray(r.T * sign), np.asarray((q * sign).T)


def forward_matrix(triad: StoredTriad) -> FloatArray:
    """N of ``y = N s + offset``: from the true vector to the nominal reading, no unit, (3, 3)."""
    inverse = np.linalg.inv(triad.parameters.matrix())
    return np.asarray(triad.correction.spec.nominal_scale * inverse)


def nominal_offset(triad: StoredTriad) -> FloatArray:
    """Nominal reading of a zero vector, SI, shape (3,)."""
    spec, bias = triad.correction.spec, triad.parameters.bias_counts
    return np.asarray(spec.nominal_scale * (bias - spec.nominal_bias_counts))


def to_kalibr(stored: Stored, noise: NoiseFile | None = None) -> Export:
    """``imu.yaml`` with the model ``scale-misalignment``; ``noise`` adds Kalibr's noise model."""
    accelerometer = triad_named(stored, "accelerometer")
    gyroscope = triad_named(stored, "gyroscope")
    body = np.eye(3)
    lines = [f"# {line}" for line in origin(stored)]
    lines += [
        "# SI reading by the data sheet = M * true + bias (accelerometer),",
        "#                               M * C_gyro_i * true + A * C_gyro_i * force + bias (gyro)",
        "imu0:",
        *_block({"T_i_b": _rows(np.eye(4))}),
    ]
    loses = list(no_sds(stored))
    if accelerometer is not None:
        lower, body = lower_and_rotation(forward_matrix(accelerometer))
        lines += _block({"accelerometers": {"M": _rows(lower)}})
        lines += _bias_comment(accelerometer)
    if gyroscope is not None:
        lines += _kalibr_gyroscope(stored, gyroscope, body)
        lines += _bias_comment(gyroscope)
    lines += _block({"model": "scale-misalignment", "rostopic": "/imu0", "time_offset": 0.0})
    noise_lines, absent, limits = _noise(noise)
    lines += noise_lines
    turned = math.degrees(math.acos(min(1.0, max(-1.0, (np.trace(body) - 1) / 2))))
    loses += [
        "Kalibr stores no bias: the comments contain the biases. Subtract them from the readings, "
        "or let the estimator determine them.",
        f"M is lower triangular in Kalibr: the body frame of the file is that of this calibration, "
        f"rotated by {turned:.3f}°.",
    ]
    if absent:
        loses.append(
            f"{', '.join(absent)} cannot be determined from poses and are missing in the file: "
            f"`pipeline noise LOG` determines them from a long log at rest; then export with "
            f"--noise.")
    loses += [f"{name} is an upper limit: {noise.log} does not show it."
              for name in limits if noise is not None]
    if gyroscope is not None and stored.gyroscope_to_accelerometer_rad is None:
        loses.append(
            "C_gyro_i assumes that gyroscope and accelerometer have the same frame: these poses do "
            "not determine the rotation between them. Log the accelerometer on the plate too."
        )
    held = {"gyroscope": ("g_sensitivity",)} if accelerometer is not None else {}
    loses += no_effects(stored, "Kalibr", held)
    return Export({"imu.yaml": "\n".join(lines) + "\n"}, tuple(loses))


def _noise(noise: NoiseFile | None) -> tuple[list[str], list[str], list[str]]:
    """The lines of Kalibr's noise model, its unknown keys, and those that are limits.

    Densities are those of continuous time: m/s²/√Hz and rad/s/√Hz, of the random walks m/s³/√Hz and
    rad/s²/√Hz, one number for the three axes.
    """
    known: dict[str, tuple[float, bool]] = {}
    if noise is not None:
        known = {f"{name}_{key}": triad.over_axes(key) for name, triad in noise.triads.items()
                 for key in ("noise_density", "random_walk")}
        known["update_rate"] = noise.rate_hz, False
    lines = []
    for key in (*NOISE_KEYS, "update_rate"):
        if key in known:
            value, is_limit = known[key]
            limit = ", upper limit" if is_limit else ""
            lines.append(f"{_block({key: float(f'{value:.6g}')})[0]}  # {NOISE_UNITS[key]}{limit}")
        else:
            lines.append(f"  # {key}: not measured; `pipeline noise` determines it")
    return (lines, [key for key in (*NOISE_KEYS, "update_rate") if key not in known],
            [key for key, (_, is_limit) in known.items() if is_limit])


def _kalibr_gyroscope(stored: Stored, gyroscope: StoredTriad, body: FloatArray) -> list[str]:
    """The gyroscope's block; ``body`` turns the accelerometer's frame into that of the file."""
    forward = forward_matrix(gyroscope)
    lower, turned = lower_and_rotation(forward)
    angles = stored.gyroscope_to_accelerometer_rad
    to_accelerometer = np.eye(3) if angles is None else Rotation.from_rotvec(angles).as_matrix()
    sensitivity = np.zeros((3, 3))
    effect = gyroscope.section.effects.get("g_sensitivity")
    if effect is not None:
        sensitivity = np.array(effect.values, float).reshape(3, 3)
    to_gyroscope = turned @ to_accelerometer.T @ body.T
    return _block({"gyroscopes": {
        "M": _rows(lower),
        "C_gyro_i": _rows(to_gyroscope),
        # G acts on the sensitive axes, T turns them into the orthogonal ones of M^-1; A takes the
        # force turned by C_gyro_i.
        "A": _rows(forward @ gyroscope.alignment @ sensitivity @ body.T @ to_gyroscope.T),
    }})


def _bias_comment(triad: StoredTriad) -> list[str]:
    row = ", ".join(f"{value:.10g}" for value in nominal_offset(triad))
    return [f"    # bias: [{row}]", f"    # {example_text(triad)}"]


class _RowByRow(yaml.SafeDumper):
    """Lists of numbers in one line, everything else in a line of its own."""

    def represent_sequence(
        self, tag: str, sequence: Iterable[Any], flow_style: bool | None = None
    ) -> yaml.SequenceNode:
        """A list as a node."""
        items = list(sequence)
        in_one_line = all(isinstance(item, float) for item in items)
        return super().represent_sequence(tag, items, in_one_line)


def _block(values: Mapping[str, Any]) -> list[str]:
    """Lines of YAML, indented by two; matrices have a line for each row."""
    text = yaml.dump(dict(values), Dumper=_RowByRow, default_flow_style=False, sort_keys=False,
                     width=math.inf)
    return [f"  {line}" for line in text.splitlines()]


def _rows(values: FloatArray) -> list[list[float]]:
    """A matrix to 12 digits, which is far below every sd."""
    return [[float(f"{value:.12g}") for value in row + 0.0] for row in values]


def to_ros(stored: Stored) -> Export:
    """``imu_calib.yaml``: ``SM * raw - bias``, the bias after scaling; raw is in counts."""
    accelerometer = triad_named(stored, "accelerometer")
    loses = [*no_sds(stored)]
    if triad_named(stored, "gyroscope") is not None:
        loses.append("imu_calib cannot store the gyroscope; the file does not contain it.")
    if accelerometer is None:
        return Export({}, (*loses, "imu_calib stores an accelerometer; there is none here."))
    spec = accelerometer.correction.spec
    m = accelerometer.parameters.matrix()
    counts = (m, m @ accelerometer.parameters.bias_counts)
    nominal = (m / spec.nominal_scale,
               m @ (accelerometer.parameters.bias_counts - spec.nominal_bias_counts))
    lines = [f"# {line}" for line in origin(stored)]
    lines += [
        "# calibrated [m/s²] = SM * raw - bias, raw in counts:",
        f"# {example_text(accelerometer)}",
        *_pair(*counts),
        "# For a driver that publishes m/s² by the data sheet, use these two instead:",
        *(f"# {line}" for line in _pair(*nominal)),
    ]
    loses.append(
        "SM and bias are for counts. If the driver publishes m/s² by the data sheet, use the pair "
        "in the comment."
    )
    lost = [effect for effect in no_effects(stored, "imu_calib") if "accelerometer" in effect]
    return Export({"imu_calib.yaml": "\n".join(lines) + "\n"}, (*loses, *lost))


def _pair(sm: FloatArray, bias: FloatArray) -> list[str]:
    """The two keys of imu_calib, a line each."""
    rows = {"SM": _rows(sm.reshape(1, -1))[0], "bias": _rows(bias.reshape(1, -1))[0]}
    return [line.removeprefix("  ") for line in _block(rows)]
