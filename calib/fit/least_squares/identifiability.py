"""Judgement whether the poses determine the model, before any number is reported.

The residual does not show it: nine poses fit nine parameters exactly, and an unseen direction
leaves the residual small while the parameters diverge. The criteria are the number of rows, the
rank, and the condition number of the column-scaled Jacobian. All S sets are judged at once; each
refused set gets an error (:data:`Refusals`).
"""

import numpy as np

from calib.effects.effect import Effect
from calib.effects.variation import about_mean
from calib.errors import CalibrationError, Contradiction, FitFailed, Remedy, Undetermined
from calib.fit.linear import RANK_TOLERANCE, unit_columns
from calib.fit.model import stack_columns
from calib.fit.rows.problem import Estimate
from calib.fit.rows.residuals import Equations
from calib.fit.rows.sensitive_axes import Shapes, evaluate_for, sensor_columns
from calib.fit.rows.whitened_rows import WhitenedRows
from calib.poses.attitudes import list_directions, natural_directions, uncovered
from calib.poses.conditions import Conditions
from calib.poses.imu_log import TRIADS, FloatArray, IntArray
from calib.poses.reference import is_free

Refusals = dict[int, CalibrationError]
"""Errors of the refused sets of a stack, by index."""

CONDITION_LIMIT = 25.0
"""Largest condition number: the 18 wedge poses give 1.4, ten usable free-hand poses up to 8; from
25 on the worst combination of parameters is known twenty times worse than the best. A judgement."""

FEWEST_SPARE_ROWS = 1  #: derived: without a degree of freedom nothing tests the fit
GAINS = ("scale", "misalignment")

VISIBLE_SHARE = 0.02
"""Share of its signal that a combination must keep when the rest of the model is projected out, and
that a parameter which is seen by itself may have outside the fitted combinations. A judgement: its
sd is then fifty times that of the combination alone."""

ROUNDING = 1e-3
"""Share of an error vector below which its part along the reading is rounding, not a signal."""

NAMED_SHARE = 0.35
"""Share of the largest part of an undetermined combination: a message names the parameters with at
least that much. It chooses words only."""

LARGEST_REFERENCE_ERROR = 2.0
"""Factor by which no plate rate and no gravity differs from its stated value. Fact."""


def scaled_condition(jacobian: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Condition number of the parameters, and the combination that the rows determine least.

    Parameters
    ----------
    jacobian : array, shape (..., r, p)

    Returns
    -------
    condition : array, shape (...,)
        Condition number of the column-scaled Jacobian, no unit; infinite without full rank.
    combination : array, shape (..., p)
        Of the scaled parameters, the one that the rows determine least.
    """
    *lead, _, p = jacobian.shape
    if p == 0:
        return np.ones(lead), np.zeros((*lead, 0))
    nothing = (jacobian == 0).all(axis=-2)
    _, singular, combinations = np.linalg.svd(unit_columns(jacobian)[0], full_matrices=False)
    largest, least = singular[..., 0], singular[..., -1]
    lost = nothing.any(axis=-1) | (least < RANK_TOLERANCE * largest)
    condition = np.where(lost, np.inf, largest / np.where(lost, 1.0, least))
    weakest = np.where(nothing.any(axis=-1)[..., None], nothing, combinations[..., -1, :])
    return condition, np.asarray(weakest)


def too_few(equations: Equations, parameters: IntArray) -> Refusals:
    """The sets with too few poses to check a fit of ``parameters`` (S,), numbers."""
    at_rest = never_turning(equations)
    if at_rest is not None:
        return dict.fromkeys(range(len(parameters)), at_rest)
    free = sum(map(is_free, equations.poses.reference.common_names))
    short = np.flatnonzero(equations.data_count - parameters - free < FEWEST_SPARE_ROWS)
    return {int(k): _too_few(equations.take(int(k)), int(parameters[k]), free) for k in short}


def _too_few(equations: Equations, parameters: int, free: int) -> Undetermined:
    triad, model, poses = equations.poses.triad, equations.model, equations.poses
    beside = f" and {free} that the poses have in common" if free else ""
    return Undetermined(
        f"{triad}: {len(poses)} poses give {equations.data_count} equations for {parameters} "
        f"parameters ({', '.join(model.names)}){beside}, which leaves nothing to check the fit "
        f"with; at least {parameters + free + FEWEST_SPARE_ROWS} are needed and 18 are "
        f"recommended. {_advice(equations)}"
    )


def never_turning(equations: Equations) -> Undetermined | None:
    """Refusal of a gain or a misalignment where all poses were at rest.

    At rest every true vector is close to zero: scale and misalignment only multiply noise and the
    bias, so they diverge with an arbitrarily small residual and a good condition number.
    """
    model, triad = equations.model, equations.poses.triad
    gains = [name for name in model.names if name in GAINS]
    if len(equations.magnitude) or not gains:
        return None
    carried = tuple(name for name in model.names if name not in GAINS) or ("bias",)
    return Undetermined(
        f"{triad}: all {len(equations.poses)} poses were taken at rest, which shows the bias and "
        f"what else errs at rest, but never {' or '.join(gains)}. Poses on the turning plate are "
        f"missing: add them, or fit {', '.join(carried)} alone.",
        Remedy("smaller_model", triad, carried),
    )


def rows_about_zero(equations: Equations, rows: WhitenedRows) -> FloatArray:
    """Whitened data rows (..., d, p) of the parameters about the zero of the corrected vector.

    About a distant false origin, bias and scale look the same; the same nine parameters about the
    zero of the corrected vector do not, and the two forms determine each other uniquely. Waves have
    no zero, and stay as they are.
    """
    terms, d = equations.terms, equations.data_count
    data = rows.jacobian[..., :d, : equations.model.size].copy()
    if terms.reading:
        at = Conditions.of_vectors(rows.vector.reshape(-1, 3))
        columns = stack_columns(terms.reading.effects, at, {}).reshape(*rows.vector.shape, -1)
        shown, last = equations.whitened(columns, rows.vector), d - equations.wave_count
        data[..., :last, terms.reading.index] = shown[..., :last, :]
        data[..., last:, terms.reading.index] *= -1
    return data


def undetermined_sets(equations: Equations, at: Estimate, basis: FloatArray) -> Refusals:
    """The sets whose poses cannot determine the model; ``at`` their solutions.

    ``basis`` (S, p, v) are the combinations of parameters that are fitted, in their units: a rank
    loss, or a condition number above ``CONDITION_LIMIT``, is refused. Effects are judged about
    their mean: their mean is a bias or a gain, and the zero of a logged column says nothing about
    what the poses determine.
    """
    limit = CONDITION_LIMIT if equations.terms.is_linear_form else CONDITION_LIMIT**2
    data, slices = rows_about_zero(equations, at.rows), equations.model.slices()
    for effect in equations.model.effects:
        if effect.acts_on not in ("reading", "noise"):
            where = slices[effect.name]
            data[..., where] = varying_columns(equations, at.rows, at.shapes, effect,
                                               data[..., where])
    rows_by_basis = data @ basis
    moves = basis.any(axis=1).sum(axis=1)
    refusals: Refusals = {}
    for count in map(int, np.unique(moves)):
        some = np.flatnonzero(moves == count)
        condition, weakest = scaled_condition(rows_by_basis[some, :, :count])
        for i in np.flatnonzero(condition > limit):
            k = int(some[i])
            combination = np.abs(basis[k, :, :count]) @ np.abs(weakest[i])
            refusals[k] = _undetermined(equations.take(k), float(condition[i]), combination, limit)
    return refusals


def _undetermined(
    equations: Equations, condition: float, combination: FloatArray, limit: float
) -> Undetermined:
    number = "without limit (rank deficient)" if condition > limit**2 else f"{condition:.0f}"
    poses = equations.poses
    return Undetermined(
        f"{poses.triad}: these {len(poses)} poses do not determine "
        f"{_involved(equations, combination)}: the "
        f"condition number is {number}, at most {limit:.0f} is accepted (the 18 wedge poses give "
        f"1.4). The residual would be small and the parameters worthless. {_advice(equations)}"
    )


def _involved(equations: Equations, combination: FloatArray) -> str:
    names = [
        f"{effect.name} {parameter}"
        for effect in equations.model.effects
        for parameter in effect.parameters
    ]
    strong = np.abs(combination) > NAMED_SHARE * np.abs(combination).max()
    return ", ".join(name for name, is_strong in zip(names, strong, strict=True) if is_strong)


def _advice(equations: Equations) -> str:
    poses = equations.poses
    turning = ~poses.reference.is_null
    if not turning.any():
        return "Poses on the turning plate are missing."
    wanted = natural_directions(corners=False)
    missing = uncovered(poses.reading[turning] - equations.start.bias, wanted)
    if 2 * len(missing) > len(wanted):
        near = [each for each in wanted if not (missing == each).all(axis=1).any()]
        faces = [each for each in missing if np.count_nonzero(each) == 1]
        first = f", first {list_directions(faces, len(faces), poses.triad)}" if faces else ""
        if not faces and poses.up is None and poses.triad in TRIADS:
            first = ("; or, if its case stood squarely on every face, state how squarely by "
                     "`attitude_sd_deg`, and six faces are enough if that is half a degree")
        return (f"Of the {len(wanted)} faces and edges, poses lie within 25° of "
                f"{list_directions(near, len(near), poses.triad) or 'none'} alone. "
                f"Add the others{first}.")
    if len(missing) == 0:
        return "Every face and edge is covered: repeat the poses, or take an effect out."
    listed = list_directions(missing, len(missing), poses.triad)
    return f"Directions with no pose within 25°: {listed}. Add those."


def varying_columns(
    equations: Equations, rows: WhitenedRows, shapes: Shapes, effect: Effect, columns: FloatArray
) -> FloatArray:
    """Whitened columns of ``effect`` about their mean; the mean is a bias or a gain.

    With the mean, the varying part would look small.

    Parameters
    ----------
    equations : Equations
    rows : WhitenedRows
        Of S sets.
    shapes : mapping of effect name to shape parameter
    effect : Effect
        Of k parameters.
    columns : array, shape (S, d, k)
        Its whitened columns, no unit.

    Returns
    -------
    array, shape (S, d, k)
        The ``columns`` themselves where the base of the model holds no part of them.
    """
    sets = len(rows.residual)
    at = equations.conditions(rows.vector)
    varying = about_mean(effect, equations.model.names, at, sets)
    if varying is effect:
        return columns
    if effect.acts_on == "reference":
        whitened = np.zeros_like(columns)
        errors = evaluate_for((sets,), varying, at, shapes)[:, equations.magnitude]
        whitened[:, : errors.shape[1]] = errors / equations.magnitude_sd[..., None]
        return whitened
    vectors = sensor_columns((varying,), at, shapes, rows.axes)
    return equations.whitened(vectors, rows.vector) * columns.any(axis=1, keepdims=True)


def misfitting_sizes(equations: Equations, rows: WhitenedRows) -> Refusals:
    """The sets that ended with vanishing gains, which fit a reference that an effect took to zero.
    """
    turning = equations.magnitude
    if not len(turning):
        return {}
    size = np.linalg.norm(rows.vector[:, turning], axis=2)
    share = np.median(size / equations.whitening.stated, axis=1)
    near = (share > 1 / LARGEST_REFERENCE_ERROR) & (share < LARGEST_REFERENCE_ERROR)
    return {int(k): _wrong_size(equations.take(int(k)), float(share[k]))
            for k in np.flatnonzero(~near)}


def _wrong_size(equations: Equations, share: float) -> CalibrationError:
    triad = equations.poses.triad
    scatters = any(each.drawn and "plate" in each.needs for each in equations.model.effects)
    if not equations.terms.reference and not scatters:
        return Contradiction(
            f"{triad}: no gain fits all poses: fitted, their typical reading "
            f"is {share:.2g} times the stated reference. The references of some poses "
            f"contradict those of the others, or their readings do: check the rate of each "
            f"run, and whether all files are of one sensor at one range."
        )
    return FitFailed(
        f"the fit of the {triad} ended at {share:.2g} times the stated "
        f"reference: an effect on the reference, or on its scatter, has taken the gains along with "
        f"it. Remove it: these poses cannot separate it from the scale.",
        Remedy("remove_effect", triad),
    )
