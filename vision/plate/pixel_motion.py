"""Test whether periodic pixels show a turning plate; its spindle and sense of rotation.

With f the periodic functions of ``vision.plate.periodic``, a point of the plate passes at v per
radian, and ∂f/∂θ + v·∇f = 0 with v = A x + b about the spindle -A⁻¹b. A has the eigenvalues ±i/N,
and so the determinant 1/N², if the picture returns N times per turn; for an object that passes in
one direction b alone explains as much as A and b. The sign of the curl is the sense of rotation,
and the ellipses that points follow are the view. Noise in ∇f biases A towards zero, by the share of
∂f/∂θ that it explains.

An object that moves to and fro, or appears and disappears, looks the same played backwards,
f(θ₀ + θ) = f(θ₀ - θ). With c_k = a_k - i b_k of the pixels p that is Re Σ c_pk² exp(-2ikθ₀) =
Σ |c_pk|² for some θ₀; for a plate, whose pixels have all phases, the left side is near 0.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.errors import EqualReturns, NoPlate, OnlyShifts
from vision.geometry import FloatArray, PlateView, view_of_ellipse

MOTION_ORDERS = 5  #: number of orders for the motion; numerical, 3 to 12 give the same
MOMENTS = 8  #: per period of the highest order; numerical
ALIKE = "(blades, spokes, equal marks)"
RIM = 0.95  # quantile of the radii of turning pixels


# Limits for a turning plate.
BACKWARDS = 0.7
"""Share of the energy that is the same played backwards. Tuned on rendered films: 0.93 and more for
motion to and fro, 0.03 and less for a plate, up to 0.49 in five real clips."""
ONCE = 0.5
"""det A of a plate that looks the same once per turn. Derived: 1, and 1/4 for one that looks the
same twice; half way by ratio."""
LOWEST = 0.025
"""Least share of the waves once and twice per return. Tuned on rendered films: blades in step with
the frames have up to 0.02, four marks that pass far from their spindle 0.03, other plates 0.25 and
more."""
EXPLAINED = 0.1
"""Least share of the change of the pixels that the motion explains: with less, its determinant is
not known to a third. Tuned on ``tests.bench.clip_study --only cut,edge_on,from_the_side``."""
PASSES = 0.9
"""Share of the explained change that one common shift explains. Derived: nine tenths; for a plate
it is the rotation that explains, unless its spindle is far outside the frame."""
MOSTLY = 0.33
"""Share of the change of the pixels that this shift, or a motion about no axis or by a part of a
turn explains; with less, a plate may be in the rest. Tuned: a lamp over part of a plate at rest has
0.47, real and rendered plates that return beside other motion up to 0.24."""


@dataclass(frozen=True, eq=False)
class Turning:
    """Rotation of the picture with growing phase.

    Attributes
    ----------
    view : PlateView
        Without perspective; the unit circle is approximately the outline of the turning pixels.
    way : int
        1 if it turns counter-clockwise as filmed, -1 clockwise.
    """

    view: PlateView
    way: int


def turning(waves: NDArray[np.float32], mask: NDArray[np.bool_]) -> Turning | None:
    """The rotation that the pixels show; None if their motion is not one turn per return.

    Parameters
    ----------
    waves : array, shape (2k + 1, p)
        Mean, cosines and sines of the pixels.
    mask : array of bool, shape (h, w)
        Positions of the pixels in the frame, row by row.

    Raises
    ------
    NoPlate
        They move as no plate can, with any symmetry.
    """
    backwards = _same_backwards(waves)
    if backwards > BACKWARDS:
        raise NoPlate(f"it goes to and fro, or comes and goes ({backwards:.0%} of how it changes "
                      f"is the same played backwards)")
    y, x = np.nonzero(_with_neighbours(mask))
    if not len(x):
        return None
    middle, scale = np.array([x.mean(), y.mean()]), float(np.hypot(x.std(), y.std()))
    u, v = (x - middle[0]) / scale, (y - middle[1]) / scale
    image, along = _low_orders(waves, mask)
    right = (image[:, y, x + 1] - image[:, y, x - 1]) / 2
    down = (image[:, y + 1, x] - image[:, y - 1, x]) / 2
    columns = np.stack([right * u, right * v, right, down * u, down * v, down], axis=-1)
    change = -along[:, y, x]
    by_change = np.sqrt((change**2).sum(axis=0))  # most pixels of a small plate are noise
    rows, change = (columns * by_change[:, None]).reshape(-1, 6), (change * by_change).ravel()
    beta, explained = _explained(rows, change)
    if explained < EXPLAINED:
        return None
    flow, at_middle = beta.reshape(2, 3)[:, :2] / scale, beta.reshape(2, 3)[:, 2]
    once = float(np.linalg.det(flow)) / explained**2
    if once < ONCE:
        _, by_shift = _explained(rows[:, [2, 5]], change)
        if by_shift > max(PASSES * explained, MOSTLY):
            raise OnlyShifts(f"it passes by in one direction (one shift explains {by_shift:.0%} of "
                             f"how it changes, turning {explained - by_shift:.0%} more)")
    by_order = (waves[1:] ** 2).sum(axis=1).reshape(2, -1).sum(axis=0)
    lowest = float(by_order[:2].sum() / by_order.sum())
    if lowest < LOWEST:
        raise EqualReturns(f"waves once and twice per return are {lowest:.0%} of how it changes, "
                           f"so it looks the same several times per turn {ALIKE}")
    # The points follow x' Q x = constant, with Q A antisymmetric.
    skew = (flow[0, 0] - flow[1, 1]) / 2
    form = np.array([[-flow[1, 0], skew], [skew, flow[0, 1]]]) * np.sign(flow[0, 1])
    squared, axes = np.linalg.eigh(form)
    if explained > MOSTLY and squared[0] <= 0:
        raise OnlyShifts(f"it turns about no common axis, though one linear motion explains "
                         f"{explained:.0%} of how it changes (as of traffic both ways)")
    if explained > MOSTLY and once < ONCE:
        raise EqualReturns(f"it moves by about {np.sqrt(once):.2f} of a turn, so it looks the same "
                           f"several times per turn {ALIKE}")
    if once < ONCE or squared[0] <= 0:
        return None
    centre = middle - np.linalg.solve(flow, at_middle)
    away = np.array([x, y], float) - centre[:, None]
    farthest = np.quantile(np.einsum("in,ij,jn->n", away, form, away), RIM,
                           weights=by_change**2, method="inverted_cdf")
    reach = np.sqrt(farthest / squared)
    view = view_of_ellipse((float(centre[0]), float(centre[1])),
                           (float(reach[0]), float(reach[1])),
                           float(np.arctan2(axes[1, 0], axes[0, 0])))
    return Turning(view, 1 if flow[1, 0] < flow[0, 1] else -1)


def _same_backwards(waves: NDArray[np.float32]) -> float:
    """Share of the energy that is the same played backwards from the best moment."""
    orders = (len(waves) - 1) // 2
    wave = waves[1 : orders + 1] - 1j * waves[orders + 1 :]
    k, moment = np.arange(1, orders + 1), np.linspace(0, np.pi, MOMENTS * orders)
    together = (np.exp(-2j * np.outer(moment, k)) @ (wave**2).sum(axis=1)).real
    return float(together.max() / max(float((np.abs(wave) ** 2).sum()), 1e-9))


def _explained(rows: FloatArray, change: FloatArray) -> tuple[FloatArray, float]:
    """The motion (k,) that best explains a change (n,) by its rows (n, k), and the share."""
    beta = np.linalg.lstsq(rows.T @ rows, rows.T @ change)[0]
    missed, of_all = float(((change - rows @ beta) ** 2).sum()), float((change**2).sum())
    return np.asarray(beta), 1 - missed / of_all if of_all > 0 else 0.0


def _with_neighbours(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pixels whose four neighbours are in the mask too, shape (h, w)."""
    inner = np.zeros_like(mask)
    inner[1:-1, 1:-1] = (mask[1:-1, 1:-1] & mask[:-2, 1:-1] & mask[2:, 1:-1]
                         & mask[1:-1, :-2] & mask[1:-1, 2:])
    return inner


def _low_orders(
    waves: NDArray[np.float32], mask: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    """Coefficients of the low orders as images, and those of ∂f/∂θ, each (2 orders, h, w)."""
    most = (len(waves) - 1) // 2
    orders = min(MOTION_ORDERS, most)
    k = np.arange(1, orders + 1, dtype=float)[:, None]
    cosine = waves[1 : orders + 1]
    sine = waves[most + 1 : most + 1 + orders]
    image, along = np.zeros((2, 2 * orders, *mask.shape))
    image[:, mask] = np.concatenate([cosine, sine])
    along[:, mask] = np.concatenate([k * sine, -k * cosine])
    return image, along
