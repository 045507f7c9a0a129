"""The certificate of a calibration, from results.json and its history: one page to be filed.

From top to bottom: the sensor and what identifies the session; each triad with its verdict,
parameters, figures and residuals; the references with their traceability; how to read it. It is
HTML with a style sheet for A4: a browser prints it, or saves it as PDF.
"""

import hashlib
import math
import re
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from calib.consistency.data_sheet import range_by_gain, range_in_words
from calib.diagnosis.verdict.wording import enumeration
from calib.effects.units import display_unit
from calib.fit.triad.calibration import TOLD_WIDENING
from calib.numbers import RPM
from calib.poses.attitudes import direction_name
from calib.poses.imu_log import AXES, SI_UNIT, FloatArray
from pipeline.drawings.charts import Canvas, Chart, rightward, upward
from pipeline.export.parts import HASH_DIGITS, Export, stood_for, temperatures
from pipeline.results.history import read_history
from pipeline.results.json_values import logged_unit, unit_of
from pipeline.results.names import PARAMETERS
from pipeline.results.read import Stored, StoredTriad
from pipeline.results.schema.file import ResultsFile
from pipeline.results.schema.rate import RateResult
from pipeline.results.schema.triad import PoseResult, PredictionResult, TriadSection
from pipeline.text.formatting import (
    DISPLAY,
    count,
    not_measured,
    relative,
    short_model,
    with_minus_signs,
    with_sd,
)
from pipeline.text.names import DISTRIBUTION, program_version

FILE_NAME = "certificate.html"
CANVAS = Canvas(320.0, 122.0, 34.0, 20.0, "chart", margin_right=3.0, margin_top=4.0)
REACH = 1.1  #: length of the axis in largest residuals with their sd; layout
LONGEST_RUN = 24  #: letters of a run's name; layout


def to_certificate(stored: Stored) -> Export:
    """``certificate.html``; equal results and history give equal bytes."""
    templates = Environment(
        loader=PackageLoader("pipeline.export", "templates"), autoescape=True,
        undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    page = templates.get_template(FILE_NAME).render(
        **certificate_content(stored), chart=residual_chart)
    return Export({FILE_NAME: page}, ())


def residual_chart(poses: Sequence[PoseResult], triad: str) -> str:
    """Residuals in the order of the poses over their noise, as SVG in the shown unit of the triad.

    A square marks a pose at rest with the plate stopped, whose residual is a length.
    """
    factor = DISPLAY[triad][1]
    residual, sd = np.array([(pose.residual, pose.sd) for pose in poses]).T * factor
    is_length = np.array([pose.reference == 0 for pose in poses])
    largest = float(np.max(np.abs(residual) + sd))
    low = 0.0 if is_length.all() else -largest
    place = np.arange(len(poses), dtype=float)
    chart = Chart(rightward(-0.5, len(place) - 0.5, CANVAS),
                  upward(REACH * low, REACH * largest, canvas=CANVAS), "", "", CANVAS)
    chart.y_axis([(value, with_minus_signs(f"{value:.2g}"))
                  for value in sorted({0.0, low, largest})])
    runs, first = [], 0
    for run, of_run in groupby(printable(pose.run) for pose in poses):
        last = first + len(list(of_run))
        runs.append(((first + last - 1) / 2, run[:LONGEST_RUN]))
        first = last
    chart.x_axis(runs)
    chart.bars(place, np.where(is_length, 0.0, -sd), sd, "band")
    for x, value, square in zip(place, residual, is_length, strict=True):
        chart.mark(x, value, int(square), "mark")
    return chart.svg(f"Residuals of the {triad}")


_MINUS = re.compile(r"(?<![\w.])-(?=\d)|(?<=\de)-(?=\d)")
NOT_RECORDED = "not recorded"


Row = tuple[str, tuple[tuple[str, str], ...]]
"""A kind of parameter: its name with unit, and up to three values with their sds, as text."""


def certificate_content(stored: Stored) -> dict[str, Any]:
    """Data for the template of the certificate.

    Raises
    ------
    UnreadableInput
        The history beside results.json is damaged.
    """
    contents = stored.contents
    return {
        "title": printable(contents.title or "Untitled session"),
        "sensor": printable(contents.sensor),
        "facts": dict(_facts(stored)),
        "triads": [_of_triad(triad) for triad in stored.triads],
        "references": list(_references(contents)),
        "notes": list(_notes(stored)),
    }


def printable(text: object) -> str:
    """A name from a file as one printable line."""
    return " ".join("".join(c if c.isprintable() else " " for c in str(text)).split())


def _facts(stored: Stored) -> Iterator[tuple[str, str]]:
    sha = stored.contents.config_sha256
    steps = [step for step in read_history(stored.folder) if step.config_sha256 == sha]
    yield "Date of calibration", steps[-1].when[:16].replace("T", " ") if steps else NOT_RECORDED
    yield "Configuration", f"SHA-256 {sha[:HASH_DIGITS]}"
    results = hashlib.sha256(stored.path.read_bytes()).hexdigest()
    yield "Results", f"SHA-256 {results[:HASH_DIGITS]}"
    yield "Program", f"{DISTRIBUTION} {program_version()}"
    if warmth := temperatures(stored):
        yield "Temperature", f"{min(warmth):.1f} to {max(warmth):.1f} °C"


def _of_triad(triad: StoredTriad) -> dict[str, Any]:
    section, diagnosis = triad.section, triad.section.diagnosis
    short = printable(diagnosis.short or diagnosis.verdict)
    return {
        "name": triad.name,
        "unit": DISPLAY[triad.name][0],
        "model": printable(short_model(section.model)),
        "range": _range(triad),
        "standing": diagnosis.standing or "open",
        "verdict": f"{short[:1].upper()}{short[1:]}",
        "explanation": _typeset(printable(diagnosis.in_words)),
        "rows": [*_base_rows(triad), *_effect_rows(triad)],
        "figures": dict(_figures(triad.name, section)),
        "prediction": _prediction(triad.name, section.prediction),
        "not_determined": ", ".join(map(printable, diagnosis.blind))
        or "nothing that was looked for",
        "poses": section.poses,
    }


def _typeset(text: str) -> str:
    """Text with minus signs, and no line break before a sign of equality or per cent."""
    return _MINUS.sub("−", text).replace(" = ", "\u00a0=\u00a0").replace(" %", "\u00a0%")


def _range(triad: StoredTriad) -> str:
    spec, unit = triad.correction.spec, SI_UNIT[triad.name]
    if not spec.bits:
        return f"logged in {logged_unit(triad.name, spec)}"
    by_gain = range_by_gain(triad.parameters.scale_counts_per_unit, spec)
    if by_gain is not None:
        return f"about {range_in_words(by_gain, triad.name)} by the measured gain, {spec.bits} bits"
    shown = math.degrees(spec.full_scale) if triad.name == "gyroscope" else spec.full_scale
    return f"±{shown:.4g} {'°/s' if triad.name == 'gyroscope' else unit}, {spec.bits} bits"


def _base_rows(triad: StoredTriad) -> Iterator[Row]:
    """Bias, scale and misalignment in the units of Angrisano et al."""
    nine = triad.parameters
    misalignment_sd, bias_sd, scale_sd = nine.sd
    of_bias, of_scale = (unit_of(key, triad.name, triad.correction.spec) for key in PARAMETERS[1:])
    yield _row(f"Bias b [{of_bias}]", nine.bias_counts, bias_sd)
    yield _row(f"Scale k⁻¹ [{of_scale}]", nine.scale_counts_per_unit, scale_sd)
    yield _row("Misalignment α [mrad]", nine.misalignment_rad * 1e3, misalignment_sd * 1e3)


def _effect_rows(triad: StoredTriad) -> Iterator[Row]:
    """Added effects in units of data sheets, three values in a row; a shape parameter alone."""
    for name, effect in triad.section.effects.items():
        unit, _, shape_unit = effect.unit.partition("; ")
        values = np.array(effect.values, float)
        sds = np.array(effect.sd, float)
        linear = len(values) - bool(shape_unit)
        shown, factor = display_unit(unit, list(values[:linear]))
        for i in range(0, linear, len(AXES)):
            label = f" {AXES[i // len(AXES)]}" if linear > len(AXES) else ""
            to = min(i + len(AXES), linear)
            yield _row(f"{printable(name)}{label} [{printable(shown)}]", values[i:to] * factor,
                       sds[i:to] * factor)
        if shape_unit:
            yield _row(f"{printable(name)} {printable(shape_unit)}", values[linear:], sds[linear:])


def _row(name: str, values: FloatArray, sds: FloatArray) -> Row:
    return name, tuple(_value(v, s) for v, s in zip(values, sds, strict=True))


def _value(value: float, sd: float) -> tuple[str, str]:
    if not math.isfinite(sd):
        return with_minus_signs(f"{value + 0.0:.6g}"), "not fitted"
    text, _, spread = with_sd(value, sd).partition(" ± ")
    if "(" in text:  # a common power of ten is behind the bracket
        power = spread.partition(")")[2]
        text, spread = text.lstrip("(") + power, spread.partition(")")[0] + power
    return with_minus_signs(text), with_minus_signs(f"± {spread}")


def _figures(triad: str, section: TriadSection) -> Iterator[tuple[str, str]]:
    unit, factor = DISPLAY[triad]
    yield "Poses", str(section.n_poses)
    yield "Residual RMS", f"{section.residual_rms * factor:.3g} {unit}"
    yield "Leave-one-out", f"{section.loo_rms * factor:.3g} {unit}"
    ratio = section.chi2 / max(section.dof, 1)
    yield "chi²/dof", f"{ratio:.{2 if ratio < 100 else 0}f} ({section.dof} dof)"
    yield "p", f"{section.p_value:.2g}"
    if section.sd_widened_by > TOLD_WIDENING:
        yield "Sds over those of the noise", f"{section.sd_widened_by:.2g}"


def _prediction(triad: str, prediction: PredictionResult | None) -> str:
    if prediction is None or prediction.sd_median is None or prediction.sd_worst is None:
        return "Only rest was measured: the gains are not known."
    unit, factor = DISPLAY[triad]
    worst = with_minus_signs(direction_name(
        np.array(prediction.worst_direction, float), triad))
    parts = prediction.parts
    typical = "" if parts is None or parts.poses is None else not_measured(triad, parts.poses, *(
        {printable(name): rms for name, rms in each.items() if rms is not None}
        for each in (parts.unseen, parts.untold)))
    return (f"Corrected magnitudes err by {prediction.sd_median * factor:.2g} {unit} (1 sd, "
            f"median over all directions), at worst by {prediction.sd_worst * factor:.2g} "
            f"{unit} ({worst}){typical}.")


# --- the reference -----------------------------------------------------------------------------


def _references(contents: ResultsFile) -> Iterator[tuple[str, str, str]]:
    """Name, value and traceability of every reference."""
    if contents.accelerometer is not None:
        gravity = contents.accelerometer.gravity
        sd = gravity.sd_m_s2
        value = f"{gravity.value_m_s2:.5f} m/s²"
        source = gravity.source
        if sd:
            value += f" ± {relative(sd / gravity.value_m_s2)}"
        else:
            source += "; counts as exact, the scale is relative to it"
        yield "Gravity", value, source
    for name, rate in contents.rate.items():
        sign = "clockwise" if rate.direction == "cw" else "counter-clockwise"
        value = (f"{rate.rate_rad_s / RPM:.4f} rpm ± "
                 f"{relative(rate.sd_rad_s / rate.rate_rad_s)}")
        direction = f", {sign}" if rate.direction else ""
        yield f"Plate, {printable(name)}", f"{value}{direction}", _rate_source(rate)


def _rate_source(rate: RateResult) -> str:
    if rate.source != "video":
        return "stated in the configuration"
    clips = [printable(clip.clip) for clip in rate.clips]
    clock, image = ((part or 0.0) / rate.rate_rad_s
                    for part in (rate.sd_parts.timebase_rad_s, rate.sd_parts.image_rad_s))
    named = clips[0] if len(clips) == 1 else f"{count(len(clips), 'clip')}, {clips[0]} first"
    return (f"{named}: {rate.revolutions or 0.0:.1f} turns in {rate.frames} frames; "
            f"clock {relative(clock)}, images {relative(image)}")


def _holds(stored: Stored) -> str:
    incomplete = [triad.name for triad in stored.triads
                  if triad.section.diagnosis.standing != "good"]
    return (f"The calibration of the {enumeration(incomplete, 'and')} is incomplete, as its verdict"
            f" says; otherwise it holds" if incomplete else "The calibration holds")


def _notes(stored: Stored) -> Iterator[str]:
    yield ("The model is s = T K (counts − b) (Angrisano et al.), T upper triangular with the "
           "misalignments, K diagonal with the inverses of the scale factors; added effects are "
           "subtracted. ± is one standard deviation (k = 1) and includes the noise of the poses "
           f"with its autocorrelation and the uncertainty of the references. {_holds(stored)} for "
           f"the stated ranges and temperatures.")
    for line in stood_for(stored):
        yield f"{printable(line)}."
    angles, gyroscope = stored.gyroscope_to_accelerometer_rad, stored.contents.gyroscope
    if angles is not None and gyroscope is not None and gyroscope.frame_sd_rad is not None:
        sds = np.array(gyroscope.frame_sd_rad, float)
        words = ", ".join(with_sd(a * 1e3, s * 1e3) for a, s in zip(angles, sds, strict=True))
        yield with_minus_signs(
            f"Rotation of the gyroscope against the accelerometer: {words} mrad.")
    mounting = stored.contents.installation
    if mounting is not None:
        roll, pitch = (with_minus_signs(f"{angle:.3f}")
                       for angle in (mounting.roll_deg, mounting.pitch_deg))
        sds = np.array(mounting.sd_deg, float)
        yield f"Mounting: roll {roll} ± {sds[0]:.2g}°, pitch {pitch} ± {sds[1]:.2g}°."
    warnings = [printable(one) for one in stored.contents.warnings]
    if warnings:
        yield f"Warnings of the run: {' '.join(warnings)}"
