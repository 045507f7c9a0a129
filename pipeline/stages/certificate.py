"""The factory certificate that a configuration states of a triad."""

import numpy as np

from calib.consistency.certificate import FactoryCertificate
from calib.poses.imu_log import Triad
from pipeline.config.load import Config
from pipeline.config.record_section import TriadCertificateSection


def certificate_of(config: Config, triad: Triad) -> FactoryCertificate | None:
    """The certificate of ``triad``; None where the configuration has none."""
    stated: TriadCertificateSection | None = (
        getattr(config.certificate, triad, None) if config.certificate else None
    )
    if stated is None:
        return None
    return FactoryCertificate(
        bias_counts=np.array(stated.bias_counts),
        scale_counts_per_unit=np.array(stated.scale_counts_per_unit),
        alignment=None if stated.alignment is None else np.array(stated.alignment),
        misalignment_rad=(
            None if stated.misalignment_rad is None else np.array(stated.misalignment_rad)
        ),
    )
