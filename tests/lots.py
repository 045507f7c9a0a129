"""From a simulated lot to pose sets, as the pipeline would make them of its logs."""

import numpy as np

from calib.poses.pose_set import PoseSet
from calib.poses.reference import CommonError, constant_reference
from calib.poses.runs.reference_runs import RATE_OF
from tests.fitting import spec_of
from tests.world.lot import Lot


def pose_sets_of(lot: Lot, noise_dof: float = 2.0) -> list[PoseSet]:
    """The poses of every evening, ``noise_dof`` behind the sd of each pose."""
    spec = spec_of(lot.triad, lot.triad.full_scale)
    n = len(lot.time_s)
    reading = spec.nominal(lot.counts)
    sd = lot.sd_counts * spec.nominal_scale
    turns = lot.force_m_s2 is not None
    force = reading if lot.force_m_s2 is None else lot.force_m_s2
    run = "plate" if turns else "rest"
    common = [CommonError(RATE_OF + run, lot.rate_sd, of_setting=True)] if turns else []
    nothing = np.zeros((n, 3))
    labels = tuple(f"pose_{i + 1:02d}" for i in range(n))
    return [
        PoseSet(
            triad="gyroscope" if turns else "accelerometer",
            label=labels,
            run=(run,) * n,
            reading=reading[i],
            sd=sd[i],
            force=force[i],
            vibration=nothing,
            spin_rad_s=np.full(n, lot.spin_rad_s),
            time_s=lot.time_s,
            expected=nothing,
            reference=constant_reference(n, float(lot.magnitude[i, 0]), common),
            sd_dof=noise_dof * n,
            columns={name: values[i] for name, values in lot.columns.items()},
        )
        for i in range(len(lot))
    ]
