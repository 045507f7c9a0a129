"""What ``pipeline fleet`` keeps of the sessions of a simulated lot: records and evidence."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from calib.diagnosis.population.evidence import Evidence
from calib.diagnosis.population.evidence_many import evidence_many
from calib.effects.catalogue import BASE
from calib.fit.batch.fit_many import ManyFits, fit_many
from calib.fit.model import Model
from calib.fit.parameters import triad_parameters
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import AXES
from pipeline.fleet.record import SessionRecord, evidence_path, write_evidence
from pipeline.fleet.rows import Row
from pipeline.results.names import PARAMETERS
from tests.fitting import spec_of
from tests.lots import pose_sets_of
from tests.world.lot import Lot


def lot_records(lot: Lot, names: Sequence[str], output: Path) -> list[SessionRecord]:
    """The records of sessions called SENSOR/EVENING; their evidence stands in ``output``."""
    sets, spec = pose_sets_of(lot), spec_of(lot.triad, lot.triad.full_scale)
    triad = sets[0].triad
    fits = fit_many(sets, Model.of(BASE))
    for part in evidence_many(fits, sets, names):
        for i, name in enumerate(part.sensors):
            write_evidence(evidence_path(output, name, triad), Evidence(
                part.trials, part.score[i], part.information[i], float(part.chi2[i]),
                float(part.dof[i]), float(part.noise_dof[i])))
    return [SessionRecord(name, name.partition("/")[0], "", 0, "",
                          (_row(fits, i, name, triad, spec, len(sets[i])),))
            for i, name in enumerate(names)]


def _row(
    fits: ManyFits, i: int, name: str, triad: str, spec: TriadSpec, n_poses: int
) -> Row:
    """The row of one session, with the parameters of its fit."""
    stack = next(each for each in fits.stacks if i in each.index)
    j = int(np.flatnonzero(stack.index == i)[0])
    value = triad_parameters(fits.model, stack.theta[j], stack.cov[j, :9, :9], spec)
    row: Row = {"session": name, "sensor": name.partition("/")[0], "triad": triad,
                "exit_code": 0, "reason": "", "warnings": 0, "n_poses": n_poses,
                "verdict": "nothing_missing", "missing": "", "chi2": float(fits.chi2[i]),
                "dof": int(fits.dof[i]), "p_value": float(fits.p_value[i])}
    for key, sd in zip(PARAMETERS, value.sd, strict=True):
        for axis, at, each in zip(AXES, getattr(value, key), sd, strict=True):
            row[f"{key}_{axis}"] = float(at)
            row[f"{key}_{axis}_sd"] = row[f"{key}_{axis}_noise_sd"] = float(each)
    return row
