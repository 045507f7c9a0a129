"""From a simulated lot to pose sets, as the pipeline would make them of its logs."""

import numpy as np

from calib.poses.pose_set import PoseSet
from calib.poses.reference import constant_reference
from tests.fitting import spec_of
from tests.world.lot import Lot


def pose_sets_of(lot: Lot, noise_dof: float = 2.0) -> list[PoseSet]:
    """The accelerometer's poses of every evening, ``noise_dof`` behind the sd of each pose."""
    spec = spec_of(lot.triad, lot.triad.full_scale)
    n = len(lot.time_s)
    reading = spec.nominal(lot.counts)
    sd = lot.sd_counts * spec.nominal_scale
    reference = constant_reference(n, lot.gravity_m_s2, [])
    nothing, at_rest = np.zeros((n, 3)), np.zeros(n)
    labels = tuple(f"pose_{i + 1:02d}" for i in range(n))
    return [
        PoseSet(
            triad="accelerometer",
            label=labels,
            run=("rest",) * n,
            reading=reading[i],
            sd=sd[i],
            force=reading[i],
            vibration=nothing,
            spin_rad_s=at_rest,
            time_s=lot.time_s,
            expected=nothing,
            reference=reference,
            sd_dof=noise_dof * n,
            columns={"temperature_c": lot.temperature_c[i]},
        )
        for i in range(len(lot))
    ]
