"""A triad's ``certificate`` section of results.json."""

from typing import Any

import numpy as np

from calib.consistency.certificate import CertificateComparison


def certificate_json(comparison: CertificateComparison) -> dict[str, Any]:
    """The section ``certificate`` of a triad, group by group; null for what has no value."""
    return {
        group.name: {
            "unit": group.unit,
            "certificate": group.certificate.tolist(),
            "certificate_sd": group.certificate_sd.tolist(),
            "difference": _plain(group.difference),
            "sigma": _plain(group.sigma),
            "per_cent": _plain(group.per_cent),
        }
        for group in comparison.groups
    }


def _plain(values: np.ndarray) -> list[float | None]:
    return [float(value) if np.isfinite(value) else None for value in values]
