"""Readings and poses in, a calibration with honest uncertainties out.

Conventions, relied on by every module here:

- Axes x, y, z in this order; arrays of vectors have shape (n, 3).
- SI inside: m/s², rad/s, s, °C. Counts exist only in :mod:`calib.poses.data_sheet` and in the log
  itself.
- Model of both triads, Angrisano et al. eq. (1): ``s = T K (s_out - b)``, T unit upper triangular
  with (alpha_z, alpha_y; alpha_x) as in eq. (2), K diagonal. Misalignments are listed (x, y, z).
- ``sd`` is one standard deviation, ``cov`` a covariance matrix.
- Absent telemetry is NaN, never None.

This package knows nothing of video, YAML, file names or the screen.
"""
