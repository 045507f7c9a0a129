"""The fingerprint of an effect in the poses of a session, under the residual that was measured.

The fingerprint is what the exact fits with and without the effect differ by, row by row. An effect
that is there has the pattern of the residual; of one that is not there no more than the noise is
fitted.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from calib.fit.least_squares.result import Fit
from calib.numbers import NO_LENGTH
from calib.poses.imu_log import FloatArray
from pipeline.drawings.charts import PLAIN, Canvas, drawing, pixel, tick_text
from pipeline.report.triad.refitted import Refits

LEFT, RIGHT = 44.0, 4.0  #: px of the drawing beside the strips; layout
STRIP, GAP, TOP, FOOT = 52.0, 28.0, 16.0, 16.0  #: height of a strip, and the room about it
NOISE = 1.0  #: sd of a whitened row
REACH = 4.0  #: sds that a strip shows at least
LETTER = 9.5  #: width of a letter of a run's name on a phone


@dataclass(frozen=True, eq=False)
class Fingerprint:
    """One effect in the rows of a fit.

    Parameters
    ----------
    measured : array, shape (d,)
        Residual without the effect, in sds.
    pattern : array, shape (d,)
        What the effect explains of it.
    visible : float
        RMS share of the effect's signature that the rest of the model leaves.
    explained : float
        Share of the measured sum of squares.
    """

    measured: FloatArray
    pattern: FloatArray
    visible: float
    explained: float


def fingerprint(refits: Refits, name: str) -> Fingerprint | None:
    """The fingerprint of one effect; None where these poses do not determine it.

    ``refits`` are those of the triad. What acts on the noise widens the sds and has no pattern.
    """
    run = refits.run.added
    effect, other = refits.effect(name), refits.flipped(name)
    if effect is None or effect.acts_on == "noise" or other is None:
        return None
    with_it, without = (refits.run, other) if name in run else (other, refits.run)
    d = with_it.fit.equations.data_count
    measured, after = (one.fit.rows.residual[:d] for one in (without, with_it))
    where = with_it.fit.model.slices()[name]
    columns = with_it.fit.rows.jacobian[:, where]
    others = np.delete(with_it.fit.rows.jacobian, np.r_[where], axis=1)
    others = others / np.maximum(np.sqrt((others**2).sum(axis=0)), NO_LENGTH)
    visible = columns - others @ np.linalg.lstsq(others, columns, rcond=None)[0]
    chi2 = float(measured @ measured)
    return Fingerprint(
        measured, measured - after,
        float(np.sqrt((visible**2).sum() / max((columns**2).sum(), NO_LENGTH))),
        max(1 - float(after @ after) / chi2, 0.0) if chi2 > 0 else 0.0,
    )


def fingerprint_svg(shape: Fingerprint, name: str, fit: Fit) -> str:
    """Two strips, a bar for every row: measured above, the fingerprint below, on one scale."""
    poses, runs = fit.equations.row_pose, fit.poses.run
    order = np.argsort(poses, kind="stable")
    reach = max(REACH, float(np.abs([shape.measured, shape.pattern]).max()))
    step = (PLAIN.width - LEFT - RIGHT) / len(order)
    parts: list[str] = []
    strips = (("measured residual [sd]", shape.measured, "measured"),
              (f"fingerprint of {name} [sd]", shape.pattern, "pattern"))
    for number, (title, values, kind) in enumerate(strips):
        middle = TOP + STRIP / 2 + number * (STRIP + GAP)
        parts += _strip(title, middle, reach)
        bars = "".join(
            f"M{pixel(LEFT + (i + 0.5) * step)} {pixel(middle)}v{pixel(-v / reach * STRIP / 2)}"
            for i, v in enumerate(values[order]) if abs(v) > reach / STRIP / 5
        )
        width = f"{max(0.7 * min(step, 6.0), 0.8):.1f}"
        parts.append(f'<path class="{kind}" stroke-width="{width}" d="{bars}"/>')
    bottom = TOP + 2 * STRIP + GAP
    names, lines = _runs([runs[k] for k in poses[order]], step, bottom)
    words = f"Measured residual and fingerprint of {name}, in sds, pose by pose."
    canvas = Canvas(PLAIN.width, bottom + lines * FOOT, LEFT, 0.0, "chart fingerprint")
    return drawing([*parts, *names], words, canvas)


def _strip(title: str, middle: float, reach: float) -> list[str]:
    """Title, noise band, zero line and numbers of one strip."""
    half, noise = STRIP / 2, NOISE / reach * STRIP / 2
    right = PLAIN.width - RIGHT
    return [
        f'<text class="title" x="{LEFT:g}" y="{pixel(middle - half - 5)}">{escape(title)}</text>',
        f'<rect class="stripe" x="{LEFT:g}" y="{pixel(middle - noise)}" '
        f'width="{right - LEFT:g}" height="{pixel(2 * noise)}"/>',
        f'<path class="zero" d="M{LEFT:g} {pixel(middle)}H{right:g}"/>',
        *(f'<text class="tick" x="{LEFT - 5:g}" y="{pixel(middle - sign * half)}" dy="4" '
          f'text-anchor="end">{text}</text>'
          for sign in (1, -1) for text in [tick_text(sign * float(f"{reach:.2g}"))]),
    ]


def _runs(run_of_row: Sequence[str], step: float, bottom: float) -> tuple[list[str], int]:
    """The names of the runs under their rows, in one line or two, and the number of lines."""
    starts = [i for i, run in enumerate(run_of_row) if i == 0 or run_of_row[i - 1] != run]
    ends = [*starts[1:], len(run_of_row)]
    texts = [run_of_row[start] for start in starts] if len(starts) > 1 else ["poses in their order"]
    lines = 1 if all(len(text) * LETTER < (end - start) * step
                     for text, start, end in zip(texts, starts, ends, strict=True)) else 2
    parts = []
    for i, (text, start, end) in enumerate(zip(texts, starts, ends, strict=True)):
        begin, finish = LEFT + start * step, LEFT + end * step
        if start:
            parts.append(f'<path class="grid" d="M{pixel(begin)} {TOP:g}V{bottom:g}"/>')
        most = max(int(lines * (finish - begin) / LETTER), 3)
        short = text if len(text) <= most else f"{text[:most - 1]}…"
        parts.append(f'<text class="tick" x="{pixel((begin + finish) / 2)}" '
                     f'y="{bottom + 13 + i % lines * FOOT:g}" '
                     f'text-anchor="middle">{escape(short)}</text>')
    return parts, lines
