"""A triad's ``certificate`` section of results.json."""

from typing import Any

from calib.consistency.certificate import CertificateComparison
from pipeline.results.json_values import numbers


def certificate_json(comparison: CertificateComparison) -> dict[str, Any]:
    """The section ``certificate`` of a triad, group by group; null for what has no value."""
    return {
        group.name: {
            "unit": group.unit,
            "certificate": group.certificate.tolist(),
            "certificate_sd": group.certificate_sd.tolist(),
            "difference": numbers(group.difference),
            "sigma": numbers(group.sigma),
            "per_cent": numbers(group.per_cent),
        }
        for group in comparison.groups
    }
