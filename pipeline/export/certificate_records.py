"""What stands on a calibration certificate, as records."""

from dataclasses import dataclass

import numpy as np

from calib.poses.imu_log import FloatArray


@dataclass(frozen=True)
class CertifiedValue:
    """One number with its sd, both as text; the sd is empty where there is none."""

    value: str
    sd: str


@dataclass(frozen=True)
class CertifiedRow:
    """One kind of parameter: its name with unit, and up to three values."""

    name: str
    values: tuple[CertifiedValue, ...]


@dataclass(frozen=True, eq=False)
class Residuals:
    """The residuals of a triad in its shown unit.

    ``value`` and ``sd`` (n,), ``run`` the name of each pose's run; ``is_length`` (n,) marks poses
    at rest with the plate stopped, whose residual is a length.
    """

    unit: str
    value: FloatArray
    sd: FloatArray
    run: tuple[str, ...]
    is_length: np.ndarray


@dataclass(frozen=True, eq=False)
class TriadPart:
    """What the certificate states of one triad."""

    name: str
    model: str
    range: str
    standing: str
    verdict: str
    explanation: str
    rows: tuple[CertifiedRow, ...]
    figures: tuple[tuple[str, str], ...]
    prediction: str
    not_determined: str
    residuals: Residuals


@dataclass(frozen=True, eq=False)
class CertificateContent:
    """Everything that the page states."""

    title: str
    sensor: str
    facts: tuple[tuple[str, str], ...]
    triads: tuple[TriadPart, ...]
    references: tuple[tuple[str, str, str], ...]
    notes: tuple[str, ...]
