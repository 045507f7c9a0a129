"""References: the magnitude that each pose should show, and its uncertainty."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib.poses.imu_log import AXES, BoolArray, FloatArray, IntArray
from calib.poses.rows import Rows

PLAUSIBLE_RATIO = 3.0
"""Ratio of a reading by the data sheet to the reference, or its inverse. Fact: ranges of one sensor
differ by factors of two and four, units by ten and fifty-seven; gains lie within a third."""

SAME_MAGNITUDE = 0.01
"""Relative difference of magnitudes that count as one (both directions of a setting of the plate,
clips of its poses). Derived: a gain's error is the same at both to 1 % of itself."""


@dataclass(frozen=True, eq=False)
class PlateRate:
    """The measured rate of the plate for one run.

    Parameters
    ----------
    name : str
        Name of the plate setting.
    rate_rad_s, sd_rad_s : array, shape (1,) or (n,)
        One rate shared by all poses, or one per pose; always positive.
    timebase_relative : float
        Relative sd of the clock, common to everything the same camera filmed; 0 if included.
    direction : str or None
        ``ccw`` or ``cw`` as filmed from above, None when unknown.
    """

    name: str
    rate_rad_s: FloatArray
    sd_rad_s: FloatArray
    timebase_relative: float = 0.0
    direction: str | None = None

    def of_poses(self, places: IntArray) -> "PlateRate":
        """The rates of some poses of the run; the same where one rate holds for all.

        Parameters
        ----------
        places : array of int, shape (k,)
        """
        if len(self.rate_rad_s) == 1:
            return self
        return replace(self, rate_rad_s=self.rate_rad_s[places], sd_rad_s=self.sd_rad_s[places])

    def doubted(self, relative: float) -> "PlateRate":
        """The same with a further relative sd."""
        return replace(self, sd_rad_s=np.hypot(self.sd_rad_s, relative * self.rate_rad_s))


@dataclass(frozen=True)
class CommonError:
    """One error shared by all poses that name it.

    Parameters
    ----------
    name : str
        Errors of the same name are the same error, also in other runs.
    sd : float
        In the unit of the magnitude, m/s² or rad/s.
    of_setting : bool
        Whether it belongs to one setting of the plate: another one brings its own.
    """

    name: str
    sd: float
    of_setting: bool = False


@dataclass(frozen=True, eq=False)
class Reference(Rows):
    """Reference magnitudes of n poses.

    Parameters
    ----------
    magnitude : array, shape (n,)
        Gravity in m/s² or plate rate in rad/s; 0 for a null pose (plate stopped).
    sd : array, shape (n,)
        The part of its sd that each pose has for itself.
    common : array, shape (n, q)
        Sd of the parts that several poses share: column j is how far one sd of the common error j
        moves each magnitude. It does not average down; it goes straight into the scale.
    common_names : tuple of str
        What the q common errors are, for the uncertainty budget.
    of_setting : frozenset of str
        Those among them that belong to one setting of the plate: another one brings its own.
    on_vector : array, shape (n, 3, q), or None
        How far one sd of each common error moves what is read, SI; None where none does.
    """

    magnitude: FloatArray
    sd: FloatArray
    common: FloatArray
    common_names: tuple[str, ...]
    of_setting: frozenset[str] = frozenset()
    on_vector: FloatArray | None = None

    def __post_init__(self) -> None:
        n = len(self.magnitude)
        assert self.sd.shape == (n,)
        assert self.common.shape == (n, len(self.common_names))

    @property
    def is_null(self) -> BoolArray:
        """Whether poses were taken with nothing to measure, shape (n,)."""
        return np.asarray(self.magnitude == 0.0)


def constant_reference(
    n: int, magnitude: float, common: Sequence[CommonError], sd: float = 0.0
) -> Reference:
    """The same magnitude for ``n`` poses.

    Parameters
    ----------
    n : int
    magnitude : float
        m/s² or rad/s.
    common : sequence of CommonError
        The errors that all n share.
    sd : float
        The part of its sd that each pose has for itself, in the unit of the magnitude.
    """
    return Reference(
        np.full(n, magnitude),
        np.full(n, sd),
        np.tile([c.sd for c in common], (n, 1)).reshape(n, len(common)),
        tuple(c.name for c in common),
        frozenset(c.name for c in common if c.of_setting),
    )


def join_references(parts: Sequence[Reference]) -> Reference:
    """The poses of several runs one after another.

    Returns
    -------
    Reference
        Common errors of the same name are the same error.
    """
    names = tuple(dict.fromkeys(name for part in parts for name in part.common_names))
    blocks = []
    for part in parts:
        block = np.zeros((len(part.magnitude), len(names)))
        for j, name in enumerate(part.common_names):
            block[:, names.index(name)] = part.common[:, j]
        blocks.append(block)
    return Reference(
        np.concatenate([part.magnitude for part in parts]),
        np.concatenate([part.sd for part in parts]),
        np.concatenate(blocks),
        names,
        frozenset().union(*(part.of_setting for part in parts)),
    )


def room_names(run: str) -> tuple[str, str]:
    """The common errors of a run by the Earth's horizontal rate, along and across the lean."""
    return f"Earth's rate along the tilt of {run}", f"Earth's rate across the tilt of {run}"


def tilt_name(run: str) -> str:
    """The common error of a run by the tilt of its plate."""
    return f"tilt of {run}"


FRAME_NAMES = tuple(f"frame angle {axis}" for axis in AXES)
"""The common errors by the rotation between both triads. Definition."""


def accelerometer_names(count: int) -> tuple[str, ...]:
    """The common errors by what the accelerometer's calibration leaves open."""
    return tuple(f"accelerometer {i + 1}" for i in range(count))


def is_free(name: str) -> bool:
    """Whether a common error is an unknown that the rows alone decide."""
    return name.startswith("tilt of ") or name in FRAME_NAMES
