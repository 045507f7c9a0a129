"""Whether the poses determine the model, judged before a number is given.

A residual says nothing about it: nine poses fit nine parameters exactly, and an unseen direction
leaves the residual small while the parameters run away. What counts are the number of rows, the
rank, and the condition number of the column-scaled Jacobian.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from calib.effects.effect import Effect
from calib.errors import Contradiction, FitFailed, Remedy, Undetermined
from calib.fit.column_scaling import RANK_TOLERANCE, orthonormal_columns, unit_columns
from calib.fit.model import stack_columns
from calib.fit.rows.sensitive_axes import sensor_columns
from calib.poses.attitudes import list_directions, natural_directions, uncovered
from calib.poses.imu_log import BoolArray, FloatArray

if TYPE_CHECKING:
    from calib.fit.rows.residuals import Equations
from calib.effects.variation import about_mean
from calib.fit.rows.whitened_rows import WhitenedRows
from calib.numbers import NO_LENGTH

CONDITION_LIMIT = 25.0
"""The 18 wedge poses give 1.4, ten usable free-hand poses up to 8; from 25 on the worst
combination of parameters is known twenty times worse than the best. A judgement."""

FEWEST_SPARE_ROWS = 1  #: derived: without a degree of freedom nothing tests the fit
GAINS = ("scale", "misalignment")

VISIBLE_SHARE = 0.02
"""Share of its signal that a combination must keep when the rest of the model is projected out.
A judgement: its sd is then fifty times that of the combination alone."""

NAMED_SHARE = 0.35
"""Of the largest part of an undetermined combination: a message names the parameters of at least
this part. It chooses words only."""

ROUNDING = 1e-3
"""Share of an error vector below which its part along the reading is rounding, not a signal."""

LARGEST_REFERENCE_ERROR = 2.0
"""No plate turns, and no site has gravity, half or twice what was stated. Fact."""


def scaled_condition(jacobian: FloatArray) -> tuple[float, FloatArray]:
    """How well the rows determine every combination of the parameters.

    Parameters
    ----------
    jacobian : array, shape (r, p)

    Returns
    -------
    condition : float
        Condition number of the column-scaled Jacobian; infinite where it has no full rank.
    combination : array, shape (p,)
        Of the scaled parameters, the one that the rows determine least.
    """
    if jacobian.shape[1] == 0:
        return 1.0, np.zeros(0)
    nothing = (jacobian == 0).all(axis=0)
    if nothing.any():
        return np.inf, nothing.astype(float)
    _, singular, combinations = np.linalg.svd(unit_columns(jacobian)[0], full_matrices=False)
    if singular[-1] < RANK_TOLERANCE * singular[0]:
        return np.inf, np.asarray(combinations[-1])
    return float(singular[0] / singular[-1]), np.asarray(combinations[-1])


def require_enough(equations: "Equations", parameters: int) -> None:
    """Refuse poses too few to check a fit of ``parameters`` with; raises :class:`Undetermined`."""
    triad, model, poses = equations.poses.triad, equations.model, equations.poses
    require_turning(equations)
    if equations.data_count - parameters < FEWEST_SPARE_ROWS:
        raise Undetermined(
            f"{triad}: {len(poses)} poses give {equations.data_count} equations for {parameters} "
            f"parameters ({', '.join(model.names)}), which leaves nothing to check the fit with; "
            f"at least {parameters + FEWEST_SPARE_ROWS} are needed and 18 are recommended. "
            f"{_advice(equations)}"
        )


def require_turning(equations: "Equations") -> None:
    """Refuse a gain or a misalignment where nothing was measured but rest.

    At rest every true vector is next to nothing: scale and misalignment only multiply noise and the
    bias, so that they run away with a residual as small as one likes and a fine condition number.
    """
    model, triad = equations.model, equations.poses.triad
    gains = [name for name in model.names if name in GAINS]
    if len(equations.magnitude) or not gains:
        return
    carried = tuple(name for name in model.names if name not in GAINS) or ("bias",)
    raise Undetermined(
        f"{triad}: all {len(equations.poses)} poses were taken at rest, which shows the bias and "
        f"what else errs at rest, but never {' or '.join(gains)}. Poses on the turning plate are "
        f"missing: add them, or fit {', '.join(carried)} alone.",
        Remedy("smaller_model", triad, carried),
    )


def require_determined(
    equations: "Equations", rows: "WhitenedRows", basis: FloatArray,
    shapes: Mapping[str, float] | None = None,
) -> None:
    """Refuse, in words, poses that cannot determine the model; ``rows`` at the solution.

    ``basis`` (p, v) are the combinations of parameters that are fitted, ``shapes`` the shape
    parameters of ``rows``, where they are not the first of their starts. Effects are judged about
    their mean: what they are there is a bias or a gain, and where a logged column has its zero says
    nothing of what the poses determine.

    Raises
    ------
    Undetermined
        A rank loss, or a condition number above ``CONDITION_LIMIT``.
    """
    triad, model, poses = equations.poses.triad, equations.model, equations.poses
    data = rows.jacobian[: equations.data_count, : model.size].copy()
    # Bias and scale look alike about a false origin that is far away; the same nine parameters
    # about the corrected vector's own zero do not, and determine each other one to one.
    if equations.on_reading:
        at = replace(equations.at_reading, vector=rows.vector)
        columns = stack_columns(equations.on_reading, at, {})
        data[:, equations.reading_index] = equations.whitened(columns, rows.vector)
    slices = model.slices()
    for effect in model.effects:
        if effect.acts_on != "reading":
            where = slices[effect.name]
            data[:, where] = _varying(equations, rows, shapes or {}, effect, data[:, where])
    condition, weakest = scaled_condition(data @ basis)
    weakest = np.abs(basis) @ np.abs(weakest)
    base_only = len(equations.reading_index) == model.size
    limit = CONDITION_LIMIT if base_only else CONDITION_LIMIT**2
    if condition <= limit:
        return
    number = "without limit (rank deficient)" if np.isinf(condition) else f"{condition:.0f}"
    raise Undetermined(
        f"{triad}: these {len(poses)} poses do not determine {_involved(equations, weakest)}: the "
        f"condition number is {number}, at most {limit:.0f} is accepted (the 18 wedge poses give "
        f"1.4). The residual would be small and the parameters worthless. {_advice(equations)}"
    )


def _involved(equations: "Equations", combination: FloatArray) -> str:
    names = [
        f"{effect.name} {parameter}"
        for effect in equations.model.effects
        for parameter in effect.parameters
    ]
    strong = np.abs(combination) > NAMED_SHARE * np.abs(combination).max()
    return ", ".join(name for name, is_strong in zip(names, strong, strict=True) if is_strong)


def _advice(equations: "Equations") -> str:
    poses = equations.poses
    turning = ~poses.reference.is_null
    if not turning.any():
        return "Poses on the turning plate are missing."
    missing = uncovered(poses.reading[turning] - equations.start.bias,
                        natural_directions(corners=False))
    if len(missing) == 0:
        return "Every face and edge is covered: repeat the poses, or take an effect out."
    return f"Directions with no pose within 25°: {list_directions(missing, most=18)}. Add those."


def visible_basis(
    equations: "Equations", rows: "WhitenedRows", shapes: Mapping[str, float]
) -> FloatArray:
    """Combinations of the parameters that the poses can see, in their units, (p, visible).

    Bias, scale and misalignment are kept whole: what they lack is refused. Of every added effect
    only the combinations are fitted that leave ``VISIBLE_SHARE`` or more of their signal after
    everything before them; the others stay at zero, and no sd is stated for them. Cross-coupling
    on wedge poses is the common case: x·y·z is zero in all of them. ``shapes`` are the shape
    parameters of ``rows``, where they are not the first of their starts.

    Raises
    ------
    Undetermined
        An added effect leaves nothing at all: these poses are blind to it.
    """
    model = equations.model
    if len(equations.reading_index) == model.size:
        return np.eye(model.size)
    jacobian = rows.jacobian[: equations.data_count, : model.size]
    known = orthonormal_columns(jacobian[:, equations.reading_index])
    blocks = np.zeros((model.size, 0))
    slices = model.slices()
    for effect in model.effects:
        where = slices[effect.name]
        block = np.zeros((model.size, where.stop - where.start))
        block[where] = np.eye(where.stop - where.start)
        if effect.acts_on != "reading":
            columns = np.where(_is_rounding(equations, rows, effect), 0.0, jacobian[:, where])
            norm = np.sqrt((_varying(equations, rows, shapes, effect, columns) ** 2).sum(axis=0))
            columns = np.where(norm > 0, columns, 0.0)
            norm = np.maximum(norm, NO_LENGTH)
            remainder = columns / norm - known @ (known.T @ (columns / norm))
            _, share, combinations = np.linalg.svd(remainder, full_matrices=False)
            lost = combinations[share <= VISIBLE_SHARE].T / norm[:, None]
            if lost.shape[1] == len(norm):
                raise Undetermined(
                    f"{equations.poses.triad}: these poses cannot see '{effect.name}': bias, "
                    f"scale, misalignment and the effects before it take up all of it. What "
                    f"separates it: {effect.page.separates}."
                )
            # Perpendicular to what is lost, in the parameters' own unit: of x·y·z on three axes
            # the sum is fitted, and parameters that are seen by themselves are left alone.
            seen = np.linalg.svd(lost.T)[2][lost.shape[1] :].T
            if lost.shape[1]:
                block = np.zeros((model.size, seen.shape[1]))
                block[where] = seen
            known = np.hstack(
                [known, orthonormal_columns(columns @ seen - known @ (known.T @ columns @ seen))]
            )
        blocks = np.hstack([blocks, block])
    return blocks


def _varying(
    equations: "Equations", rows: "WhitenedRows", shapes: Mapping[str, float], effect: Effect,
    columns: FloatArray,
) -> FloatArray:
    """Columns (d, k) of ``effect`` about their mean, in which the rest is a bias or a gain.

    With that, what varies would look small.
    """
    varying = about_mean(effect, equations.model.names)
    if varying is effect:
        return columns
    at = equations.conditions(rows.vector)
    if effect.acts_on == "reference":
        whitened = np.zeros_like(columns)
        errors = varying.evaluate(at, shapes.get(effect.name))[equations.magnitude]
        whitened[: len(errors)] = errors / equations.magnitude_sd[:, None]
        return whitened
    vectors = sensor_columns((varying,), at, shapes, rows.axes)
    return equations.whitened(vectors, rows.vector) * columns.any(axis=0)


def _is_rounding(equations: "Equations", rows: "WhitenedRows", effect: Effect) -> BoolArray:
    """Which parameters of ``effect`` (k,) only err across the readings: no length shows them."""
    if effect.acts_on == "reference" or effect.in_square:
        return np.zeros(len(effect.parameters), dtype=bool)
    columns = sensor_columns((effect,), equations.conditions(rows.vector), {}, rows.axes)
    n = rows.vector / np.maximum(np.linalg.norm(rows.vector, axis=1, keepdims=True), NO_LENGTH)
    seen = np.einsum("ni,nik->nk", n, columns)
    seen[equations.null] = np.linalg.norm(columns[equations.null], axis=1)
    whole = np.sqrt((columns**2).sum(axis=(0, 1)))
    return np.asarray(np.sqrt((seen**2).sum(axis=0)) < ROUNDING * whole)


def require_size(equations: "Equations", rows: "WhitenedRows") -> None:
    """Refuse the trivial solution: gains of nothing fit a reference that an effect took to zero."""
    size = np.linalg.norm(rows.vector[equations.magnitude], axis=1)
    stated = equations.poses.reference.magnitude[equations.magnitude]
    share = float(np.median(size / stated)) if len(stated) else 1.0
    if not 1 / LARGEST_REFERENCE_ERROR < share < LARGEST_REFERENCE_ERROR:
        if not equations.on_reference:
            raise Contradiction(
                f"{equations.poses.triad}: no gain fits all poses: fitted, their typical reading "
                f"is {share:.2g} times the stated reference. The references of some poses "
                f"contradict those of the others, or their readings do: check the rate of each "
                f"run, and whether all files are of one sensor at one range."
            )
        raise FitFailed(
            f"the fit of the {equations.poses.triad} ended at {share:.2g} times the stated "
            f"reference: an effect on the reference has taken the gains along with it. Remove it: "
            f"these poses cannot separate it from the scale.",
            Remedy("remove_effect", equations.poses.triad),
        )
