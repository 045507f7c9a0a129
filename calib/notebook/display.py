"""Display of a calibration in a notebook: its tables as HTML, and its partial residuals.

The partial residuals are orthogonal to the model's own parameters, so that the points lie on the
line of slope 1 if the effect is present, and scatter about zero if it is not (Cook and Weisberg's
added-variable plot).
"""

from html import escape
from typing import TYPE_CHECKING

import numpy as np

from calib.assess import AssessedTriad
from calib.diagnosis.hypotheses.signature import whole_columns
from calib.effects.effect import Effect
from calib.fit.linear import orthonormal_columns
from calib.poses.imu_log import AXES, SI_UNIT, FloatArray
from calib.rounding import with_sd

if TYPE_CHECKING:
    from matplotlib.figure import Figure


NAME_WIDTH = 24  #: width of a parameter's name in a terminal; a width of text
Parameter = tuple[str, str, float, float]  #: name, unit, value, sd (NaN where it has none)


def name_of(effect: str | Effect) -> str:
    """The name of an effect, given by its name or as an object."""
    return effect if isinstance(effect, str) else effect.name


def parameters_of(assessed: AssessedTriad) -> list[Parameter]:
    """Every parameter: misalignment, bias and scale as in Angrisano et al., and the added ones."""
    calibration = assessed.calibration
    unit, base = SI_UNIT[calibration.triad], calibration.parameters
    in_si = calibration.spec.encoding == "si" and calibration.spec.si_per_unit == 1
    of_bias, of_scale = (unit, "1") if in_si else ("counts", f"counts/({unit})")
    values = (base.misalignment_rad, base.bias_counts, base.scale_counts_per_unit)
    rows = [
        (f"{name} {axis}", of, float(value[i]), float(sd[i]))
        for name, of, value, sd in zip(
            ("misalignment", "bias", "scale"), ("rad", of_bias, of_scale), values, base.sd,
            strict=True)
        for i, axis in enumerate(AXES)
    ]
    effects = {effect.name: effect for effect in calibration.fit.model.effects}
    for name, (value, sd) in calibration.effect_values().items():
        effect = effects[name]
        labels = [*effect.parameters, *(["shape"] if effect.shape else [])]
        rows += [(f"{name} {label}".strip(), effect.unit_for(calibration.triad), float(v), float(s))
                 for label, v, s in zip(labels, value, sd, strict=True)]
    return rows


def head(assessed: AssessedTriad) -> str:
    """One line: triad, poses, model, residuals."""
    fit, unit = assessed.calibration.fit, SI_UNIT[assessed.calibration.triad]
    comparison = assessed.comparison
    return (f"{fit.poses.triad}, {len(fit.poses)} poses, {' + '.join(fit.model.names)}: "
            f"residual {comparison.residual_rms:.3g} {unit}, "
            f"leave-one-out {comparison.loo_rms:.3g} {unit}, "
            f"chi²/dof {fit.chi2 / fit.dof:.3g} with {fit.dof} degrees of freedom")


def text(assessed: AssessedTriad) -> str:
    """Head, parameters and verdict for a terminal."""
    rows = [f"  {name:<{NAME_WIDTH}} {with_sd(value, sd)} {unit}"
            for name, unit, value, sd in parameters_of(assessed)]
    return "\n".join([head(assessed), *rows, *map(str, assessed.calibration.fit.poses.notes),
                      assessed.diagnosis.text])


def html(assessed: AssessedTriad) -> str:
    """The same as a table for a notebook; names that come from a table are escaped."""
    rows = "".join(
        f"<tr><td>{escape(name)}</td><td style='text-align:right'>{escape(with_sd(value, sd))}</td>"
        f"<td>{escape(unit)}</td></tr>" for name, unit, value, sd in parameters_of(assessed))
    notes = "".join(f"<p>{escape(note)}</p>" for note in assessed.calibration.fit.poses.notes)
    return (f"<p><b>{escape(head(assessed))}</b></p><table><tr><th>parameter</th><th>value ± sd"
            f"</th><th>unit</th></tr>{rows}</table>{notes}<p>{escape(assessed.diagnosis.text)}</p>")


def figure(assessed: AssessedTriad) -> "Figure":
    """Residuals of every pose, fitted and left out, and the noise band of one and two sds."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    unit = SI_UNIT[assessed.calibration.triad]
    one = assessed.comparison.poses
    number = np.arange(1, len(one) + 1)
    sd = np.array([pose.sd for pose in one])
    drawing = Figure(figsize=(8.0, 3.6), layout="constrained")
    axes = drawing.subplots()
    for times, shade in ((2, 0.12), (1, 0.22)):
        axes.fill_between(number, -times * sd, times * sd, step="mid", alpha=shade, lw=0,
                          color="tab:gray", label=f"noise, ±{times} sd")
    axes.plot(number, [pose.residual for pose in one], "o", color="tab:blue", label="residual")
    axes.plot(number, [pose.left_out for pose in one], "x", color="tab:orange",
              label="leave-one-out")
    axes.axhline(0, color="black", lw=0.6)
    axes.set(xlabel="pose", ylabel=f"magnitude less reference, {unit}")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_title(head(assessed).replace(": ", "\n", 1), fontsize=9)
    drawing.legend(loc="outside lower center", fontsize=8, ncols=4, frameon=False)
    return drawing


def partial_residuals(assessed: AssessedTriad, effect: Effect) -> tuple[FloatArray, FloatArray]:
    """The part of the residual that an effect explains, and the residual, in sds of each row.

    Parameters
    ----------
    assessed : AssessedTriad
        Of a model without the effect.
    effect : Effect
        That the poses can evaluate.

    Returns
    -------
    explained, residual : array, shape (d,)
        In sds.
    """
    fit = assessed.calibration.fit
    d = fit.equations.data_count
    columns = whole_columns(fit, effect)
    whole = np.zeros((len(fit.rows.residual), columns.shape[-1]))
    whole[:d] = columns
    basis = orthonormal_columns(fit.rows.jacobian)
    free = whole - basis @ (basis.T @ whole)
    residual = fit.rows.residual - basis @ (basis.T @ fit.rows.residual)
    size = np.linalg.lstsq(free, residual)[0]
    return np.asarray((free @ size)[:d]), np.asarray(residual[:d])


def partial_figure(assessed: AssessedTriad, effect: Effect) -> "Figure":
    """The partial residuals as a figure, a colour for each run."""
    from matplotlib.figure import Figure

    explained, residual = partial_residuals(assessed, effect)
    fit = assessed.calibration.fit
    runs = np.array(fit.poses.run)[fit.equations.row_pose][: len(explained)]
    drawing = Figure(figsize=(6.0, 4.2), layout="constrained")
    axes = drawing.subplots()
    for run in dict.fromkeys(runs):
        axes.plot(explained[runs == run], residual[runs == run], "o", ms=4, label=str(run))
    reach = float(np.abs(explained).max(initial=1.0))
    axes.plot([-reach, reach], [-reach, reach], color="black", lw=0.8)
    axes.axhline(0, color="black", lw=0.4)
    share = float((explained @ residual) / max(float(residual @ residual), np.finfo(float).tiny))
    axes.set(xlabel=f"what {effect.name} explains, sds of the row",
             ylabel="what the model leaves, sds of the row")
    axes.set_title(f"{fit.poses.triad}: {effect.name} explains {share:.0%} of the squares of the "
                   f"residual", fontsize=9)
    axes.legend(fontsize=8, frameon=False)
    return drawing
