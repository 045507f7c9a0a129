"""The factory certificate of a configuration beside a calibrated triad: results and screen."""

from typing import Any

import numpy as np

from calib.certificate import Certificate, CertificateComparison, compare_certificate
from calib.poses.imu_log import AXES
from pipeline.config.load import Config
from pipeline.config.schema import TriadCertificate
from pipeline.console.format import aligned, with_sd
from pipeline.stages.triads import TriadResult


def compare_with_certificate(config: Config, result: TriadResult) -> CertificateComparison | None:
    """Lay a triad beside its certificate; None where the file has none for it."""
    stated: TriadCertificate | None = (
        getattr(config.certificate, result.triad) if config.certificate else None
    )
    if stated is None:
        return None
    certificate = Certificate(
        bias_counts=np.array(stated.bias_counts),
        scale_counts_per_unit=np.array(stated.scale_counts_per_unit),
        alignment=None if stated.alignment is None else np.array(stated.alignment),
        misalignment_rad=(
            None if stated.misalignment_rad is None else np.array(stated.misalignment_rad)
        ),
    )
    calibration = result.calibration
    return compare_certificate(calibration.parameters, certificate, calibration.spec)


def certificate_json(found: CertificateComparison) -> dict[str, Any]:
    """A triad's ``certificate`` in results.json, group by group; null for what has no value."""
    return {
        group.name: {
            "unit": group.unit,
            "certificate": group.certificate.tolist(),
            "certificate_sd": group.certificate_sd.tolist(),
            "difference": _plain(group.difference),
            "sigma": _plain(group.sigma),
            "per_cent": _plain(group.per_cent),
        }
        for group in found.groups
    }


def certificate_lines(found: CertificateComparison) -> list[str]:
    """An aligned table: estimate, certificate, difference in sigma and per cent."""
    rows = [["", "", "estimate", "certificate", "difference", "sigma", "%"]]
    for group in found.groups:
        for j, axis in enumerate(AXES):
            rows.append(
                [
                    f"{group.name} [{group.unit}]" if j == 0 else "",
                    axis,
                    with_sd(float(group.estimate[j]), float(group.sd[j])),
                    with_sd(float(group.certificate[j]), float(group.certificate_sd[j])),
                    f"{group.difference[j]:+.4g}",
                    f"{group.sigma[j]:+.1f}",
                    "" if np.isnan(group.per_cent[j]) else f"{group.per_cent[j]:+.3f}",
                ]
            )
    return aligned(rows)


def _plain(values: np.ndarray) -> list[float | None]:
    return [float(value) if np.isfinite(value) else None for value in values]
