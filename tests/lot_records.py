"""What ``pipeline fleet`` keeps of the sessions of a simulated lot: records and evidence."""

from collections.abc import Sequence
from pathlib import Path

from calib.diagnosis.population.evidence import evidence_of
from calib.effects.catalogue import BASE
from calib.fit.least_squares.result import Fit
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.parameters import triad_parameters
from calib.poses.data_sheet import TriadSpec
from calib.poses.imu_log import AXES
from pipeline.fleet.sessions import SessionRecord, evidence_path, write_evidence
from pipeline.fleet.table import Row
from pipeline.results.names import PARAMETERS
from tests.fitting import spec_of
from tests.lots import pose_sets_of
from tests.world.lot import Lot


def lot_records(lot: Lot, names: Sequence[str], output: Path) -> list[SessionRecord]:
    """The records of sessions called SENSOR/EVENING; their evidence stands in ``output``."""
    sets, spec = pose_sets_of(lot), spec_of(lot.triad, lot.triad.full_scale)
    triad = sets[0].triad
    fits = [fit(each, Model.of(BASE)) for each in sets]
    for name, each in zip(names, fits, strict=True):
        write_evidence(evidence_path(output, name, triad), evidence_of(each))
    return [SessionRecord(name, name.partition("/")[0], "", 0, "", (_row(each, name, spec),))
            for name, each in zip(names, fits, strict=True)]


def _row(one: Fit, name: str, spec: TriadSpec) -> Row:
    """The row of one session, with the parameters of its fit."""
    value = triad_parameters(one.model, one.theta, one.cov, spec)
    row: Row = {"session": name, "sensor": name.partition("/")[0], "triad": one.poses.triad,
                "exit_code": 0, "reason": "", "warnings": 0, "n_poses": len(one.poses),
                "verdict": "nothing_missing", "missing": "", "chi2": one.chi2,
                "dof": one.dof, "p_value": one.p_value}
    for key, sd in zip(PARAMETERS, value.sd, strict=True):
        for axis, at, each in zip(AXES, getattr(value, key), sd, strict=True):
            row[f"{key}_{axis}"] = float(at)
            row[f"{key}_{axis}_sd"] = row[f"{key}_{axis}_noise_sd"] = float(each)
    return row
