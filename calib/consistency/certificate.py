"""Comparison of a calibration with a factory certificate, independent of the choice of frame.

The magnitude of gravity does not change under a rotation, so a calibration by magnitudes knows
``M = T K`` only up to a rotation from the left: only what ``MᵀM`` determines can be compared. A
certificate states gains and an alignment matrix A in the frame of its case, from the true vector to
the sensed one: ``u - b = G A s``. Then ``(G A)⁻¹ = Q M`` with Q a rotation, and the QR
decomposition of ``(G A)⁻¹`` gives the unique upper triangular M, hence k and alpha of Angrisano et
al. eq. (2), that a magnitude calibration of the same sensor would find. Three of the six alignment
angles remain.

A printed value is known to half its last digit. This uncertainty is added to that of the estimate;
otherwise every calibration finer than a certificate of two decimals would contradict it.
"""

from dataclasses import dataclass

import numpy as np

from calib.errors import CalibrationError
from calib.fit.parameters import TriadParameters
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import FloatArray
from calib.poses.samples.converter_steps import printed_unit

LARGEST_MISALIGNMENT = 0.5
"""Largest difference of an element of an alignment matrix from that of the unit matrix. Derived:
half of what an exchanged or mirrored axis, or a gain in the matrix, makes."""


@dataclass(frozen=True, eq=False)
class FactoryCertificate:
    """Statements of a certificate about one triad.

    Parameters
    ----------
    bias_counts, scale_counts_per_unit : array, shape (3,)
        Offsets, and gains in counts per SI unit.
    alignment : array, shape (3, 3), or None
        A, from the true vector to the sensed one; None where the certificate has none.
    misalignment_rad : array, shape (3,), or None
        alpha of eq. (2) instead, where somebody has published that.

    Raises
    ------
    CalibrationError
        Both forms of the alignment, gains that are not positive, or a matrix that is no alignment.
    """

    bias_counts: FloatArray
    scale_counts_per_unit: FloatArray
    alignment: FloatArray | None = None
    misalignment_rad: FloatArray | None = None

    def __post_init__(self) -> None:
        if self.alignment is not None and self.misalignment_rad is not None:
            raise CalibrationError(
                "certificate: `alignment` and `misalignment_rad` are both given; they say the same "
                "in two ways. Delete the one that is not printed on the certificate."
            )
        if (self.scale_counts_per_unit <= 0).any():
            raise CalibrationError(
                f"certificate: scale_counts_per_unit has {self.scale_counts_per_unit.min():g}, but "
                f"gains are positive counts per m/s² or rad/s. A negative sign belongs to the axes "
                f"of the sensor, not to the certificate."
            )
        if self.alignment is not None:
            beside = np.abs(self.alignment - np.eye(3)).max()
            if beside > LARGEST_MISALIGNMENT:
                raise CalibrationError(
                    f"certificate: alignment differs from the unit matrix by {beside:g}, where an "
                    f"alignment matrix stays within {LARGEST_MISALIGNMENT:g}. Give it row by row, "
                    f"without the gains."
                )


@dataclass(frozen=True, eq=False)
class Compared:
    """One group of parameters, x, y, z; all arrays (3,).

    ``sigma`` is the difference in units of both sds together; ``per_cent`` is the difference
    relative to the certificate for scales, to half the converter's range for biases (NaN for logs
    in physical units), and 100 times the difference in radians for misalignments (cross-axis
    sensitivity as data sheets state it).
    """

    name: str
    unit: str
    estimate: FloatArray
    sd: FloatArray
    certificate: FloatArray
    certificate_sd: FloatArray
    per_cent: FloatArray

    @property
    def difference(self) -> FloatArray:
        """Estimate less certificate, (3,), in its unit (:attr:`unit`)."""
        return np.asarray(self.estimate - self.certificate)

    @property
    def sigma(self) -> FloatArray:
        """Difference in sds, (3,)."""
        return np.asarray(self.difference / np.hypot(self.sd, self.certificate_sd))


def rounding_sd(values: FloatArray) -> float:
    """Sd of values printed to as many decimals as the longest of them needs.

    Rounding is uniform over one unit of the last digit: its sd is that unit over √12.

    Examples
    --------
    >>> round(rounding_sd(np.array([549.7, 552.7, 550.4])), 4)
    0.0289
    """
    return float(printed_unit(values.reshape(-1, 1))[0] / np.sqrt(12))


def frame_free(gain: FloatArray, aligned: FloatArray) -> tuple[FloatArray, FloatArray]:
    """k⁻¹ (3,), counts per SI unit, and alpha (3,), rad, of eq. (2): ``G A`` without its frame."""
    upper = np.linalg.qr(np.linalg.inv(gain[:, None] * aligned), mode="r")
    upper = upper * np.sign(np.diag(upper))[:, None]  # QR leaves the sign of each row open
    k = np.diag(upper)
    t = upper / k
    return 1 / k, np.array([t[1, 2], t[0, 2], t[0, 1]])


def compare_certificate(
    parameters: TriadParameters, certificate: FactoryCertificate, spec: TriadSpec
) -> dict[str, Compared]:
    """Compare ``parameters`` with ``certificate``, whatever frame the certificate uses.

    Parameters
    ----------
    parameters : TriadParameters
        The estimate, with its covariance.
    certificate : FactoryCertificate
    spec : TriadSpec
        For the range that bias differences are relative to.

    Returns
    -------
    dict of str to Compared
        Misalignment where one is certified, bias and scale.
    """
    aligned, aligned_sd = np.eye(3), 0.0
    stated = certificate.alignment is not None or certificate.misalignment_rad is not None
    if certificate.alignment is not None:
        aligned, aligned_sd = certificate.alignment, rounding_sd(certificate.alignment)
    gain = certificate.scale_counts_per_unit
    gain_sd = rounding_sd(gain)
    k, alpha = frame_free(gain, aligned)
    k_sd, alpha_sd = _frame_free_sd(gain, gain_sd, aligned, aligned_sd)
    if certificate.misalignment_rad is not None:
        alpha = certificate.misalignment_rad
        alpha_sd = np.full(3, rounding_sd(alpha))
        # k and alpha of eq. (2) are stated together: no frame to remove.
        k, k_sd = gain, np.full(3, gain_sd)
    sd_alpha, sd_bias, sd_scale = parameters.sd
    low, high = spec.count_range
    bias_difference = parameters.bias_counts - certificate.bias_counts
    half_range = (high - low) / 2
    groups = [
        Compared(
            "misalignment", "rad", parameters.misalignment_rad, sd_alpha, alpha, alpha_sd,
            100 * (parameters.misalignment_rad - alpha),
        ),
        Compared(
            "bias", "counts", parameters.bias_counts, sd_bias, certificate.bias_counts,
            np.full(3, rounding_sd(certificate.bias_counts)),
            100 * bias_difference / half_range if np.isfinite(half_range) else np.full(3, np.nan),
        ),
        Compared(
            "scale", "counts per unit", parameters.scale_counts_per_unit, sd_scale, k, k_sd,
            100 * (parameters.scale_counts_per_unit / k - 1),
        ),
    ]
    return {group.name: group for group in (groups if stated else groups[1:])}


def _frame_free_sd(
    gain: FloatArray, gain_sd: float, aligned: FloatArray, aligned_sd: float
) -> tuple[FloatArray, FloatArray]:
    """Sds of both results of :func:`frame_free` from the rounding of the printed values.

    The diagonal of an alignment matrix is 1 by the unit length of its rows, whatever its decimals.
    """
    k, alpha = frame_free(gain, aligned)
    moves = [(gain_sd * unit, np.zeros((3, 3))) for unit in np.eye(3)]
    for i, j in np.argwhere(~np.eye(3, dtype=bool)):
        moves.append((np.zeros(3), aligned_sd * np.outer(np.eye(3)[i], np.eye(3)[j])))
    changed = [frame_free(gain + a, aligned + b) for a, b in moves]
    k_sd = np.sqrt(sum((moved - k) ** 2 for moved, _ in changed))
    return k_sd, np.sqrt(sum((moved - alpha) ** 2 for _, moved in changed))
