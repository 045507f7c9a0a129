"""Data of the boxes of a plate setting: the phase residual of a clip by its terms.

With r the angle residual of the frames in use without any term and X the columns of the terms, the
constant rate projected out of both, every set of terms is fitted here by least squares of r on its
columns. The page carries the RMS and the coefficients of each set; r and X themselves come for the
frames that the charts show. Columns are scaled to an RMS of 1, angles are in degrees.
"""

from collections.abc import Sequence

import numpy as np

from calib.fit.linear import RANK_TOLERANCE
from calib.poses.imu_log import FloatArray, IntArray
from pipeline.drawings.charts import nice_limit
from pipeline.report.page_templates import rounded
from pipeline.results.json_values import Json
from pipeline.stages.rate import SettingRate
from vision.rate.diagnosis import SMALLEST_SHARE
from vision.rate.terms import CONSTANT_RATE, MEANING, StatedFit

DIGITS_SHOWN = 3  #: digits of the dots that the page draws
MOST_DOTS = 400  #: dots of a chart of the phase; a clip of a minute has two to four times as many
SHOWN_SHARE = 99.5  #: per cent of the residuals that a chart of the phase shows
ANGLE_BINS = 36  #: bins of 10°: half a wave of a twice-per-turn term has nine; chosen
LEAST_LIMIT_DEG = 1e-6  #: limit of a chart where the residual vanishes


def angle_means(angle_deg: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Middles (b,), in °, of bins of angles (n,) that hold any; means of values, in their unit."""
    frames, edges = np.histogram(angle_deg, ANGLE_BINS, (-180.0, 180.0))
    sums, _ = np.histogram(angle_deg, edges, weights=values)
    seen = frames > 0
    return ((edges[:-1] + edges[1:]) / 2)[seen], sums[seen] / frames[seen]


def shown_frames(fit: StatedFit) -> tuple[IntArray, float]:
    """Indices (≤ MOST_DOTS,) of frames that charts show, and the limit of their axis in degrees."""
    used = np.flatnonzero(fit.used)
    kept = used[np.unique(np.linspace(0, len(used) - 1, min(len(used), MOST_DOTS)).astype(int))]
    residual = np.degrees(fit.residual_rad)
    largest = float(np.percentile(np.abs(residual[fit.used]), SHOWN_SHARE))
    limit = nice_limit(max(largest, LEAST_LIMIT_DEG))
    return kept[np.abs(residual[kept]) <= limit], limit


def rate_terms_json(rate: SettingRate, number: int) -> Json:
    """Data that the page needs to refit clip ``number`` of a plate setting."""
    fit = rate.clips[number].fit
    names = [name for name in fit.columns if name != CONSTANT_RATE]
    frames = np.flatnonzero(fit.used)
    residual, columns = _projected(fit, frames, names)
    stacked = np.hstack(columns)
    shown, limit = shown_frames(fit)
    place = np.searchsorted(frames, shown)
    angle = np.degrees(fit.angle_rad[frames])
    return {
        "setting": rate.name,
        "limit": limit,
        "smallest_share": SMALLEST_SHARE,
        "terms": [
            {"name": name, "meaning": MEANING[name], "in_model": name in fit.model,
             "columns": column.shape[1]}
            for name, column in zip(names, columns, strict=True)
        ],
        # By the bits of the number of a set: bit i means that term i is in it.
        "sets": [_fitted(residual, columns, [bool(number >> i & 1) for i in range(len(names))])
                 for number in range(2 ** len(names))],
        "y": rounded(residual[place], DIGITS_SHOWN),
        "x": [rounded(column[place], DIGITS_SHOWN) for column in stacked.T],
        "mean_y": rounded(angle_means(angle, residual)[1], DIGITS_SHOWN),
        "mean_x": [rounded(angle_means(angle, column)[1], DIGITS_SHOWN) for column in stacked.T],
    }


def _fitted(
    residual: FloatArray, columns: Sequence[FloatArray], ticked: Sequence[bool]
) -> Json:
    """RMS, degrees, and the coefficients of all columns of all terms, 0 for those not ticked."""
    beta = [np.zeros(column.shape[1]) for column in columns]
    inside = [column for column, on in zip(columns, ticked, strict=True) if on]
    rest = residual
    if inside:
        whole = np.hstack(inside)
        solved = np.linalg.lstsq(whole, residual, rcond=RANK_TOLERANCE)[0]
        rest = residual - whole @ solved
        parts = iter(np.split(solved, np.cumsum([column.shape[1] for column in inside])[:-1]))
        beta = [next(parts) if on else zero for zero, on in zip(beta, ticked, strict=True)]
    return {"rms": float(np.sqrt(np.mean(rest**2))), "beta": rounded(np.concatenate(beta))}


def _projected(
    fit: StatedFit, frames: IntArray, names: list[str]
) -> tuple[FloatArray, list[FloatArray]]:
    """Residual without any term, degrees (n,), and the columns (n, k) of each term, unit RMS."""
    q, _ = np.linalg.qr(fit.columns[CONSTANT_RATE][frames])

    def without_rate(values: FloatArray) -> FloatArray:
        return np.asarray(values - q @ (q.T @ values))

    residual = fit.residual_rad[frames]
    for term in fit.terms:
        residual = residual + fit.columns[term.name][frames] @ term.value
    columns = [without_rate(fit.columns[name][frames]) for name in names]
    columns = [column / np.sqrt((column**2).mean(axis=0)) for column in columns]
    return np.degrees(without_rate(residual)), columns
