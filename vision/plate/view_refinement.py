"""Error of the view, from the plate's own motion.

D_i = S + T(φ - θ_i) is the model of frame i (``vision.plate.template``). If the view is wrong by
a small change p (shift, stretch, perspective, read-out: ``PlateView.adjusted``) the frame differs
from it, in plate coordinates, by

    e_i = d_i - T = -Σ_j B_j (R(θ_i) p)_j - δθ_i ∂T/∂φ,

because an error fixed to the camera turns backwards as seen from the plate. B_j, the change of T
per unit of each parameter, does not depend on i, so that one small matrix serves all frames, and
no outline or calibration pattern is needed to find the axis: the motion determines it.
"""

import numpy as np
from numpy.typing import NDArray

from vision.geometry import VIEW_PARAMETERS, FloatArray
from vision.plate.polar import Grid, Spectra, Strips, ring_spectra, ring_strips, turns

#: Relative to the mean diagonal of the normal matrix; keeps parameters that the frames do not
#: determine at zero. Tuned on tests.bench.vision_scenes.
RIDGE = 0.0001


def motion_basis(turning: Spectra, radius: FloatArray, azimuths: int) -> NDArray[np.float32]:
    """Change of T per unit of each distortion and of the angle, shape (9, r, n).

    Shift, stretch, perspective and a rotation that grows along a direction, two of each.
    """
    k = np.arange(turning.shape[-1])
    image = np.fft.irfft(turning, azimuths, axis=-1)
    by_angle = np.fft.irfft(1j * k * turning, azimuths, axis=-1)
    by_radius = np.gradient(image, radius, axis=0)
    azimuth = np.arange(azimuths) * 2 * np.pi / azimuths
    c, s = np.cos(azimuth), np.sin(azimuth)
    c2, s2 = np.cos(2 * azimuth), np.sin(2 * azimuth)
    r = radius[:, None]
    return np.stack([
        by_radius * c - by_angle / r * s, by_radius * s + by_angle / r * c,
        by_radius * r * c2 - by_angle * s2, by_radius * r * s2 + by_angle * c2,
        -(r**2) * c * by_radius, -(r**2) * s * by_radius,
        by_angle * r * c, by_angle * r * s, by_angle,
    ]).astype(np.float32)


def view_change(
    misfit: Strips, angle_rad: FloatArray, turning: Spectra, grid: Grid, free: int
) -> FloatArray:
    """Least-squares change of the view, each frame's own angle left free.

    Parameters
    ----------
    misfit : array, shape (f, r, n)
        Residual of the frames.
    angle_rad : array, shape (f,)
    turning : array, shape (r, k)
        Spectrum of T.
    grid : Grid
    free : int
        Only the first ``free`` of the view's parameters change.

    Returns
    -------
    array, shape (7,)
        The argument of ``PlateView.adjusted``, on the plate: in plate radii.
    """
    basis = motion_basis(turning, grid.radius, grid.azimuths)
    weighted = basis * grid.weight()[:, None]
    normal = np.vecdot(weighted[:, None], basis).sum(axis=-1).astype(float)
    spectra = ring_spectra(misfit) * turns(angle_rad, turning.shape[-1])
    back = ring_strips(spectra, grid.azimuths)
    # Ring by ring: so small a product stays on one thread, beside the decoder's.
    shown = -np.vecdot(back[:, None], weighted).sum(axis=-1).astype(float)  # (f, 9)

    # The frame's own angle, the last column, is eliminated.
    field, angle = slice(0, len(basis) - 1), len(basis) - 1
    coupling = normal[field, angle] / normal[angle, angle]
    reduced = normal[field, field] - np.outer(coupling, normal[angle, field])
    pull = shown[:, field] - shown[:, angle, None] * coupling  # (f, 8)

    turn = np.zeros((len(angle_rad), angle, angle))
    for first, order in ((0, 1), (2, 2), (4, 1), (6, 1)):
        c, s = np.cos(order * angle_rad), np.sin(order * angle_rad)
        turn[:, first, first], turn[:, first, first + 1] = c, s
        turn[:, first + 1, first], turn[:, first + 1, first + 1] = -s, c
    # Frames are read out downwards: the last two distortions have one possible direction.
    possible = np.zeros((angle, VIEW_PARAMETERS))
    possible[:6, :6] = np.eye(6)
    possible[6:, 6] = grid.view.down / np.hypot(*grid.view.down)
    turn = turn @ possible[:, :free]
    matrix = np.einsum("fai,faj->ij", turn, reduced @ turn)
    matrix += RIDGE * np.trace(matrix) / free * np.eye(free)
    change = np.zeros(VIEW_PARAMETERS)
    change[:free] = np.linalg.solve(matrix, np.einsum("fai,fa->i", turn, pull))
    return change
