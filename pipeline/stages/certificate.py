"""The factory certificate of a configuration beside a calibrated triad."""


import numpy as np

from calib.consistency.certificate import (
    CertificateComparison,
    FactoryCertificate,
    compare_certificate,
)
from pipeline.config.load import Config
from pipeline.config.record_section import TriadCertificateSection
from pipeline.stages.triads import TriadResult


def compare_with_certificate(config: Config, result: TriadResult) -> CertificateComparison | None:
    """Compare a calibrated triad with its certificate.

    Returns
    -------
    CertificateComparison or None
        None where the configuration has no certificate of this triad.
    """
    stated: TriadCertificateSection | None = (
        getattr(config.certificate, result.triad, None) if config.certificate else None
    )
    if stated is None:
        return None
    certificate = FactoryCertificate(
        bias_counts=np.array(stated.bias_counts),
        scale_counts_per_unit=np.array(stated.scale_counts_per_unit),
        alignment=None if stated.alignment is None else np.array(stated.alignment),
        misalignment_rad=(
            None if stated.misalignment_rad is None else np.array(stated.misalignment_rad)
        ),
    )
    calibration = result.calibration
    return compare_certificate(calibration.parameters, certificate, calibration.spec)


