"""The comparison of a triad with its factory certificate, as a table."""

import numpy as np

from calib.consistency.certificate import CertificateComparison
from calib.poses.imu_log import AXES
from pipeline.text.formatting import with_sd
from pipeline.text.tables import table_lines


def certificate_lines(comparison: CertificateComparison) -> list[str]:
    """An aligned table: estimate, certificate, difference in sds and per cent."""
    rows = [["", "", "estimate", "certificate", "difference", "in sd", "%"]]
    for group in comparison.groups:
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
    return table_lines(rows)
