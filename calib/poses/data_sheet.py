"""The data sheet of a triad: full scale, bits, encoding, and the start values that they give.

Angrisano et al. eq. (12): a converter of n bits over [-y, +y] starts the calibration at
``b = (2^n - 1)/2`` counts and ``k = 2y/(2^n - 1)`` SI units per count.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from calib.poses.imu_log import TRIADS, FloatArray, ImuLog

LARGEST_DRIFT = 0.02
"""Share of gravity by which a low-cost accelerometer drifts between its calibration and its use.
Fact: 0.02 %/K of gain and 0.5 to 0.9 mg/K of offset (MPU-6050) make 1.4 to 2.2 % over 20 K."""

LARGEST_SI = 1e9
"""Reading, m/s² or rad/s, of no sensor. Fact: shock accelerometers end at 1e6 m/s²."""

Encoding = Literal["offset-binary", "twos-complement", "unsigned-twos-complement", "si"]


@dataclass(frozen=True)
class TriadSpec:
    """One triad as described by its data sheet.

    Parameters
    ----------
    full_scale : float
        Largest reading in SI units (m/s² or rad/s); ``inf`` for logs already in physical units.
    bits : int
        Converter width; 0 for logs already in physical units.
    encoding : str
        ``offset-binary`` (0 ... 2^n - 1), ``twos-complement`` (-2^(n-1) ... 2^(n-1) - 1),
        ``unsigned-twos-complement`` (the same bits logged as 0 ... 2^n - 1, so that -1 stands as
        2^n - 1; biases are signed counts), or ``si`` for logs in physical units, where "counts" are
        multiples of ``si_per_unit``.
    si_per_unit : float
        Only for ``si``: SI units per logged unit (1 for m/s² and rad/s).
    """

    full_scale: float
    bits: int
    encoding: Encoding
    si_per_unit: float = 1.0

    @property
    def nominal_scale(self) -> float:
        """k of eq. (12), SI units per count."""
        if self.encoding == "si":
            return self.si_per_unit
        if self.encoding.endswith("twos-complement"):
            # Data sheets of this family state counts per unit as 2^(n-1) / full scale.
            return self.full_scale / float(2 ** (self.bits - 1))
        return 2.0 * self.full_scale / float(2**self.bits - 1)

    @property
    def nominal_bias_counts(self) -> float:
        """b of eq. (12), the "false origin" of the converter, in counts."""
        return (2**self.bits - 1) / 2.0 if self.encoding == "offset-binary" else 0.0

    def signed(self, logged: FloatArray) -> FloatArray:
        """Counts of the converter from the numbers in a log.

        Parameters
        ----------
        logged : array, shape (..., 3)
            As the log's encoding has them.

        Returns
        -------
        array, the same shape
            Counts. Numbers that no such converter gives stay as they are, outside
            :attr:`count_range`.
        """
        if self.encoding != "unsigned-twos-complement":
            return logged
        codes = 2.0**self.bits
        stands_for_negative = (logged >= codes / 2) & (logged < codes)
        return np.asarray(np.where(stands_for_negative, logged - codes, logged))

    @property
    def count_range(self) -> tuple[float, float]:
        """Lowest and highest value the converter can give, in counts."""
        if self.encoding == "si":
            limit = self.full_scale / self.si_per_unit
            return -limit, limit
        if self.encoding.endswith("twos-complement"):
            half = 2 ** (self.bits - 1)
            return float(-half), float(half - 1)
        return 0.0, float(2**self.bits - 1)

    def nominal(self, counts: FloatArray) -> FloatArray:
        """Readings by the data sheet alone.

        Parameters
        ----------
        counts : array, shape (..., 3)
            As the log's encoding has them.

        Returns
        -------
        array, the same shape
            m/s² or rad/s.
        """
        counts = self.signed(counts)
        return np.asarray((counts - self.nominal_bias_counts) * self.nominal_scale)


Specs = Mapping[str, TriadSpec]  #: data sheets by triad; a triad without one is ignored


def signed_log(log: ImuLog, specs: Specs) -> ImuLog:
    """A log whose readings are counts of the converter.

    In a log of codes −1 stands 65,535 above 0, so that neither noise about zero nor a value between
    two samples can be told before.

    Parameters
    ----------
    log : ImuLog
        As the log's encodings have it, or already with signs.
    specs : mapping of str to TriadSpec
    """
    accelerometer, gyroscope = (
        specs[triad].signed(log.readings(triad)) if triad in specs else log.readings(triad)
        for triad in TRIADS)
    return replace(log, accelerometer=accelerometer, gyroscope=gyroscope)
