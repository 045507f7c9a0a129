"""What the report's tick boxes refit with: the rows of a fit and the columns of every effect.

The page solves, in JavaScript, the least squares problem that one step of the solver solves,

    y = [B, C_1, C_2, ...] β + residual      y = r + Σ C_j θ_j

the sum over the effects that were added to the model,
with r the whitened residual of the fit, B the columns of bias, scale, misalignment and of the
errors that the references have in common (their prior rows last), and C_j those of an added
effect, ticked or not. With the model's own effects ticked the result is the fit itself; everything
else is linear about it. Columns are scaled to unit length and rounded to ``DIGITS``.

An effect with a shape parameter (the time constant of a warm-up) is taken at the value of its joint
refit, and carries one column more: the derivative with respect to it,
zero where that value is at a bound.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from calib.diagnosis.hypotheses.listed import candidate_effects
from calib.diagnosis.hypotheses.signature import effect_columns, whole_columns
from calib.diagnosis.search.refit import refit
from calib.diagnosis.verdict.ranking import Candidate
from calib.effects.catalogue import UnknownEffect, find_effect
from calib.effects.effect import Effect
from calib.effects.units import display_unit
from calib.fit.column_scaling import RANK_TOLERANCE, unit_columns
from calib.fit.least_squares.identifiability import VISIBLE_SHARE
from calib.fit.least_squares.result import MISFIT_P_VALUE, Fit
from calib.fit.rows.residuals import Equations
from calib.fit.validation.leave_one_out import LARGEST_LEVERAGE
from calib.poses.imu_log import FloatArray
from pipeline.report.effect_fit import over_all_rows
from pipeline.report.payload import rounded
from pipeline.report.pose_charts import SHOWN_SD
from pipeline.report.svg import NICE
from pipeline.results.json_values import Json
from pipeline.stages.triads import TriadResult
from pipeline.text.formatting import DISPLAY

SHAPE_STEP = 1e-3  #: relative step of the derivative with respect to a shape parameter
FEWEST_DOF = 4
"""Degrees of freedom that a ticked model leaves at least. Tuned: with two the page's refit of first
order missed the exact residual by up to 45 % (``tests/pipeline/report/test_browser.py``)."""
BLIND_REASON = (
    "these poses cannot determine it: bias, scale, misalignment and the effects in the model have "
    "the same signature"
)


@dataclass(frozen=True, eq=False)
class Box:
    """One effect that can be ticked.

    ``columns`` (d, k) are the change of the whitened data rows per unit of minus each parameter,
    the shape parameter's last; ``start`` (k,) what is added to the fitted coefficients to give the
    parameters: 0 but for the shape. ``theta`` (k,) are the coefficients of an effect that is in
    the model. ``judged`` are the columns, without the shape's, by which the solver judges what the
    poses see: those at the first start of the shape parameter.
    """

    effect: Effect
    columns: FloatArray
    judged: FloatArray
    start: FloatArray
    theta: FloatArray | None


def constants_json() -> Json:
    """The levels that the page's script shares with the solver and the charts."""
    return {
        "visible_share": VISIBLE_SHARE,
        "smallest_block": 1 - LARGEST_LEVERAGE,
        "misfit_p_value": MISFIT_P_VALUE,
        "fewest_dof": FEWEST_DOF,
        "shown_sd": SHOWN_SD,
        "nice": NICE,
    }


def refit_json(result: TriadResult, defined: Mapping[str, Effect]) -> Json:
    """Everything that the page needs to refit one triad; ``defined`` are the user's effects."""
    fit = result.calibration.fit
    equations = fit.equations
    unit, factor = DISPLAY[result.triad]
    root = np.sqrt(fit.weight)
    boxes = tuple(_boxes(result, defined))
    base = _base_columns(fit) * root[:, None]
    y = fit.rows.residual * root
    for box in boxes:
        if box.theta is not None:
            y = y + over_all_rows(box.columns, len(y)) * root[:, None] @ box.theta
    d = equations.data_count
    return {
        "triad": result.triad,
        "unit": unit,
        "y": rounded(y),
        "row_unit": rounded(equations.row_sd * factor),  # sd of every data row, as shown
        "root": rounded(root),  # of the weight that the robust loss left every row
        "row_pose": equations.row_pose.tolist(),
        "labels": list(fit.poses.label),
        "is_null": [bool(null) for null in equations.is_null],
        "noise_dof": float(fit.poses.noise_dof),
        # By refits without each pose; the page's own, of one step, is scaled to it.
        "loo": result.comparison.loo_rms * factor,
        "base": [rounded(column) for column in unit_columns(base)[0].T],
        "base_fitted": int(base.shape[1] - len(fit.eta)),
        "effects": [_box_json(box, root[:d], result) for box in boxes]
        + list(_unseen(result)),
    }


def _base_columns(fit: Fit) -> FloatArray:
    """Columns (r, b + q) of bias, scale, misalignment, and of the common errors."""
    p = fit.model.size
    reading = fit.equations.reading_index
    return np.hstack([fit.rows.jacobian[:, reading], fit.rows.jacobian[:, p:]])


def _boxes(result: TriadResult, defined: Mapping[str, Effect]) -> Iterator[Box]:
    """The effects of the model first, then the candidates, the most probable first."""
    fit = result.calibration.fit
    slices = fit.model.slices()
    for effect in fit.model.effects:
        if effect.acts_on == "reading":
            continue
        shape = fit.shapes.get(effect.name)
        theta = fit.theta[slices[effect.name]]
        yield _with_derivative(fit, fit.equations, effect, shape, theta, in_model=True)
    rank = {c.name: i for i, c in enumerate(result.diagnosis.ranking) if c.kind == "listed"}
    every = candidate_effects(fit, tuple(defined.values()), tuple(fit.poses.columns))
    listed = [e for e in every if e.name in rank]
    for effect in sorted(listed, key=lambda e: rank[e.name]):
        extended = fit.equations.extended([effect])
        shape = best_shape(fit, effect)
        columns = _columns(fit, extended, effect, shape)
        size = _sizes(fit, columns)
        yield _with_derivative(fit, extended, effect, shape, size, in_model=False)


def _columns(fit: Fit, equations: Equations, effect: Effect, shape: float | None) -> FloatArray:
    """Columns (d, k) of ``effect`` as the solver of ``equations`` would take its first step on."""
    theta = np.zeros(equations.model.size)
    theta[: fit.model.size] = fit.theta
    shapes = {**fit.shapes, **({} if shape is None else {effect.name: shape})}
    slices = equations.model.slices()
    jacobian = equations.rows(theta, fit.eta, shapes).jacobian[: equations.data_count]
    columns = -jacobian[:, slices[effect.name]]
    if effect.constant_is not in slices or effect.acts_on == "reference":
        return columns  # a gain errs by the reading's length, not by what the reference says
    # About their mean, as the solver judges what is seen of it: the rest is a bias or a gain, which
    # takes it up and leaves the effect's own parameters as they are.
    constant = whole_columns(fit, effect, shape) - effect_columns(fit, effect, shape)
    constant[: len(equations.magnitude)] *= 1 - equations.common_relative @ fit.eta[:, None]
    return columns - constant


def _with_derivative(
    fit: Fit, equations: Equations, effect: Effect, shape: float | None, theta: FloatArray,
    in_model: bool,
) -> Box:
    columns = _columns(fit, equations, effect, shape)
    judged = columns if effect.shape is None else _columns(
        fit, equations, effect, effect.shape.starts[0])
    start = np.zeros(len(theta))
    if shape is not None:
        step = SHAPE_STEP * shape
        up, down = (_columns(fit, equations, effect, shape + by) for by in (step, -step))
        derivative = (up - down) @ theta / (2 * step)
        assert effect.shape is not None
        if effect.shape.is_at_bound(shape):
            derivative = np.zeros_like(derivative)  # the solver does not go beyond the bound
        columns = np.column_stack([columns, derivative])
        start, theta = np.append(start, shape), np.append(theta, 0.0)
    return Box(effect, columns, judged, start, theta if in_model else None)


def _with_columns(fit: Fit, columns: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Unit columns of the model and ``columns`` (d, k), their lengths, and the residual, weighted.
    """
    root = np.sqrt(fit.weight)
    full = np.hstack([fit.rows.jacobian, over_all_rows(columns, len(root))])
    return *unit_columns(full * root[:, None]), fit.rows.residual * root


def _left(fit: Fit, columns: FloatArray) -> FloatArray:
    """What the model and ``columns`` (d, k) leave of the whitened residual, (r,)."""
    unit, _, r = _with_columns(fit, columns)
    return np.asarray(r - unit @ np.linalg.lstsq(unit, r, rcond=RANK_TOLERANCE)[0])


def _sizes(fit: Fit, columns: FloatArray) -> FloatArray:
    """The parameters (k,) that the residual asks for."""
    unit, norm, r = _with_columns(fit, columns)
    beta = np.linalg.lstsq(unit, r, rcond=RANK_TOLERANCE)[0] / norm
    return np.asarray(beta[-columns.shape[1] :])


def best_shape(fit: Fit, effect: Effect) -> float | None:
    """The shape value of the joint refit, which begins where the linearised one leaves least.

    None without a shape.
    """
    shape = effect.shape
    if shape is None:
        return None

    equations = fit.equations.extended([effect])

    def cost(value: float) -> float:
        remainder = _left(fit, _columns(fit, equations, effect, value))
        return float(remainder @ remainder)

    start = min(shape.starts, key=cost)
    joint = refit(fit, [effect.from_shape(start)])
    return start if joint is None else joint.fit.shapes[effect.name]


def _box_json(box: Box, root: FloatArray, result: TriadResult) -> Json:
    effect = box.effect
    unit, norm = unit_columns(box.columns * root[:, None])
    judged, judged_norm = unit_columns(box.judged * root[:, None])
    unit_of_effect = effect.unit_for(result.triad)
    candidate = next(
        (c for c in result.diagnosis.ranking if c.name == effect.name and c.kind == "listed"), None
    )
    sizes = box.theta if box.theta is not None else candidate.size if candidate else np.zeros(0)
    said, factor = display_unit(unit_of_effect, sizes)
    parameters = [{"name": name, "unit": said, "factor": factor} for name in effect.parameters]
    if effect.shape is not None:
        parameters.append({"name": effect.shape.name, "unit": effect.shape.unit, "factor": 1.0})
    return {
        "name": effect.name,
        "physics": effect.physics,
        "separates": effect.page.separates,
        "in_model": box.theta is not None,
        "share": 0.0 if candidate is None else _share(candidate, result.calibration.fit),
        "aliases": [] if candidate is None else list(candidate.aliases),
        "is_named": bool(result.diagnosis.named_class(effect.name)),
        "has_shape": effect.shape is not None,
        "start": rounded(box.start),
        "parameters": parameters,
        "norm": rounded(norm),
        "columns": [rounded(column) for column in unit.T],
        # Only where they are not the columns themselves.
        "judged": [rounded(column) for column in judged.T] if effect.shape else None,
        "judged_norm": rounded(judged_norm) if effect.shape else None,
        "reason": None,
    }


def _share(candidate: Candidate, fit: Fit) -> float:
    """Of chi², that the effect alone takes off; 0 where noise alone could."""
    return candidate.chi2_drop / fit.chi2 if candidate.p_value < MISFIT_P_VALUE else 0.0


def _unseen(result: TriadResult) -> Iterator[Json]:
    """Effects that cannot be ticked, and why."""
    for name in result.diagnosis.blind:
        try:
            separates = find_effect(name).page.separates
        except UnknownEffect:  # a user's own effect has no page
            separates = ""
        yield _grey(name, BLIND_REASON, separates)
    for name, reason in result.diagnosis.unavailable.items():
        yield _grey(name, reason, "")


def _grey(name: str, reason: str, separates: str) -> Json:
    return {
        "name": name, "reason": reason, "separates": separates, "in_model": False, "aliases": []
    }
