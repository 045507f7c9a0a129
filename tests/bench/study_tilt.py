"""What a plate that leans shows, on fresh evenings of an MPU-6050 of its own each.

    python -m tests.bench.study_tilt --sessions evening --seeds 20 --tilt 0.3 2 5 10 20
    python -m tests.bench.study_tilt --seeds 12 --tilt 10 --tug 0.005
    python -m tests.bench.study_tilt --sessions three_minutes --seeds 12 --tilt 20
    python -m tests.bench.study_tilt --sessions three_minutes --seeds 12 --tilt 0.3 20 --poses 36

``evening``: 18 poses at rest and 18 on the plate at one speed, an ordinary drive, with and without
a g-sensitivity whose nine elements are drawn at the typical size. Printed are how often it is
named, what else is, the rms deviation in stated sds of its elements where it is fitted, and which
share of the errors of corrected rates, with what was named in the model, lies within one and two
stated sds (the median, and that of the direction), over rates and gravity in random directions.
With ``--tug`` a cable turns the case by up to so many rad once per turn, at a place of its own in
each evening; printed too is how often the fit has no waves.
``three_minutes``: nine mountings, both triads from the plate; 18 poses at rest and 18 on the plate
beside them. ``twice``: nine mountings with an effect of attitude in the accelerometer, drawn at the
typical size: what the rows of what comes twice per turn add, and what they would in a gyroscope.
"""

import argparse
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from calib.assess import AssessedTriad, assess, calibrate
from calib.effects.catalogue import BASE, find_effect
from calib.errors import CalibrationError
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.triad.calibration import TriadCalibration
from calib.poses.conditions import Conditions
from calib.poses.imu_log import FloatArray
from calib.poses.pose_set import PoseSet
from calib.poses.runs.ring import ANGLES, TO_WAVES
from tests.fitting import pose_sets, tilted_pose_sets
from tests.world.bench import Turntable
from tests.world.designs import SLOW, paper_design, tilted_design
from tests.world.hidden import Hidden
from tests.world.imu import G_STANDARD, MPU_SPREAD, Sensor, another_unit, mpu6050
from tests.world.make_data import WOW
from tests.world.plate import PlateMotion
from tests.world.session import Session, simulate
from tests.world.truth import Parameters, g_sensitivity_seen

TYPICAL = np.deg2rad(0.1) / G_STANDARD  #: (rad/s)/(m/s²), of an MPU-6050
IN_DEG_S_PER_G = float(np.rad2deg(1.0)) * G_STANDARD
FRESH = 52_000  #: first seed
DIRECTIONS = 200  #: of rate and gravity in one session
MOTION = PlateMotion(SLOW, wow=WOW)


def unit_of(seed: int) -> tuple[Sensor, FloatArray]:
    """A unit of its own and its g-sensitivity, (rad/s)/(m/s²)."""
    rng = np.random.default_rng([FRESH + seed, 1])
    return another_unit(mpu6050(), MPU_SPREAD, rng), TYPICAL * rng.standard_normal((3, 3))


def evening(
    seed: int, tilt_deg: float, hide: bool, tug_rad: float = 0.0
) -> tuple[Session, FloatArray]:
    """The published design on a plate that leans, and the truth of its g-sensitivity."""
    sensor, size = unit_of(seed)
    design = paper_design(sensor, MOTION)
    table = leaning(design.turntable, tilt_deg, seed, tug_rad)
    hidden = (Hidden("g_sensitivity", "gyroscope", size),) if hide else ()
    session = simulate(replace(design, turntable=table, sample_rate_hz=50.0), FRESH + seed, hidden)
    return session, size * hide


def tugging(size_rad: float, seed: int) -> Callable[[FloatArray, FloatArray], FloatArray]:
    """A small rotation about one line of the room, as by a cable, once per turn."""
    place = np.random.default_rng([FRESH + seed, 4]).uniform(0, 2 * np.pi)

    def rocking(angle: FloatArray, _: FloatArray) -> FloatArray:
        turned = np.stack([np.cos(angle), -np.sin(angle), np.zeros_like(angle)], axis=-1)
        return np.asarray(size_rad * np.exp(2 * (np.cos(angle - place) - 1))[..., None] * turned)
    return rocking


def errors(session: Session, size: FloatArray, found: AssessedTriad, seed: int) -> FloatArray:
    """Errors of corrected rates in random directions, (2, n).

    In sds: the stated median, and that stated for the nearest direction.
    """
    rng = np.random.default_rng([FRESH + seed, 2])
    unit = rng.standard_normal((2, DIRECTIONS, 3))
    unit /= np.linalg.norm(unit, axis=2, keepdims=True)
    sensor = session.design.sensor
    force, triad, spec = 9.80267 * unit[0], sensor.gyroscope, found.calibration.spec
    felt = triad.project(SLOW * unit[1]) + force @ size.T
    nominal = spec.nominal(spec.signed(felt * triad.gain + triad.offset))
    seen = force @ session.accelerometer.case_to_orthogonal.T
    at = Conditions.of_vectors(nominal, force=seen)
    corrected = np.linalg.norm(found.calibration.correct(at), axis=1)
    assert found.prediction is not None
    true = unit[1] @ session.gyroscope.case_to_orthogonal.T
    nearest = np.argmax(true @ found.prediction.directions.T, axis=1)
    own = found.prediction.sd[0, nearest]
    return np.asarray((corrected - SLOW) / np.stack(
        [np.full_like(own, found.prediction.sd_median), own]))


def study_evenings(tilt_deg: float, hide: bool, seeds: range, tug_rad: float = 0.0) -> None:
    """Print what was named of the evenings at one tilt."""
    named, wrong, refused, without = 0, 0, 0, 0
    z, covered = [np.zeros(0)], [np.zeros((2, 0))]
    for seed in seeds:
        session, size = evening(seed, tilt_deg, hide, tug_rad)
        try:
            _, poses, specs = pose_sets(session)
            found = assess(poses, Model.of(BASE), specs[1])
        except CalibrationError:
            refused += 1
            continue
        names = found.diagnosis.names
        named += "g_sensitivity" in names
        wrong += bool(set(names) - ({"g_sensitivity"} if hide else set()))
        poses = found.calibration.fit.poses
        without += poses.ring is None
        if poses.ring is not None:
            with_it = fit(poses, Model.of([*BASE, "g_sensitivity"]))
            where = with_it.model.slices()["g_sensitivity"]
            truth = g_sensitivity_seen(session.design.sensor, size).ravel()
            z.append((with_it.theta[where] - truth) / np.sqrt(np.diag(with_it.cov)[where]))
        if names:
            more = [*BASE, *(name for name in names if find_effect(name))]
            found = assess(poses, Model.of(more), specs[1])
        covered.append(np.abs(errors(session, size, found, seed)))
    of_elements, every = np.concatenate(z), np.hstack(covered)
    spread = f"{np.sqrt(np.mean(of_elements**2)):.2f}" if of_elements.size else "-"
    print(f"{tilt_deg:g}°, {'hidden' if hide else 'nothing'}: named {named} of {len(seeds)}, wrong "
          f"names {wrong}, refused {refused}, without waves {without}; "
          f"rms z of the elements {spread}; within one and two "
          + " and ".join(f"{kind} {100 * np.mean(each < 1):.0f} %, {100 * np.mean(each < 2):.0f} %"
                         for kind, each in zip(("median sds", "sds of the direction"), every,
                                               strict=True)), flush=True)


def leaning(table: Turntable, tilt_deg: float, seed: int, tug_rad: float = 0.0) -> Turntable:
    """A plate that leans any way: along it the Earth's rate looks like a g-sensitivity."""
    heading = np.random.default_rng([FRESH + seed, 3]).uniform(0, 2 * np.pi)
    tilt = np.radians(tilt_deg) * np.array([np.cos(heading), np.sin(heading)])
    return replace(table, tilt_rad=(float(tilt[0]), float(tilt[1])),
                   rocking=tugging(tug_rad, seed) if tug_rad else None)


def nine_mountings(tilt_deg: float, seed: int, tug_rad: float) -> tuple[Session, FloatArray]:
    """Both triads from the leaning plate, and the truth of the g-sensitivity."""
    sensor, size = unit_of(seed)
    design = tilted_design(tilt_deg, sensor, MOTION)
    table = leaning(design.turntable, tilt_deg, seed, tug_rad)
    design = replace(design, turntable=table, sample_rate_hz=50.0)
    return simulate(design, FRESH + seed, (Hidden("g_sensitivity", "gyroscope", size),)), size


def study_three_minutes(tilt_deg: float, seeds: range, mountings: int, tug_rad: float) -> None:
    """Print how nine mountings, or 36 poses, come out against the truth."""
    told = 0
    rms: dict[str, list[FloatArray]] = {}
    in_sd: dict[str, list[FloatArray]] = {}
    chi2 = []
    for seed in seeds:
        if mountings == 9:
            session, size = nine_mountings(tilt_deg, seed, tug_rad)
            accelerometer, gyroscope, specs = tilted_pose_sets(session)
        else:
            session, size = evening(seed, tilt_deg, True, tug_rad)
            accelerometer, gyroscope, specs = pose_sets(session)
        sensor, seen = session.design.sensor, gyroscope.ring is not None
        model = Model.of([*BASE, "g_sensitivity"] if seen else BASE)
        both = (calibrate(accelerometer, Model.of(BASE), specs[0], seek_mistakes=False),
                calibrate(gyroscope, model, specs[1], seek_mistakes=False))
        told += bool(both[0].fit.poses.notes)
        chi2.append([each.fit.chi2 / each.fit.dof for each in both])
        for each, truth in zip(both, (session.accelerometer, session.gyroscope), strict=True):
            for name, error, sd in deviations(each, truth):
                rms.setdefault(name, []).append(error)
                in_sd.setdefault(name, []).append(error / sd)
        if not seen:
            continue
        where = both[1].fit.model.slices()["g_sensitivity"]
        error = both[1].fit.theta[where] - g_sensitivity_seen(sensor, size).ravel()
        rms.setdefault("g_sensitivity [°/s per g]", []).append(error * IN_DEG_S_PER_G)
        in_sd.setdefault("g_sensitivity [°/s per g]", []).append(
            error / np.sqrt(np.diag(both[1].fit.cov)[where]))
    for name, each in rms.items():
        print(f"{tilt_deg:g}°, {mountings} poses, {name}: rms error "
              f"{np.sqrt(np.mean(np.square(each))):.3g}, rms z "
              f"{np.sqrt(np.mean(np.square(in_sd[name]))):.2f}", flush=True)
    print(f"chi²/dof {np.mean(chi2, axis=0).round(2)}, waves of the accelerometer said to be "
          f"disturbed in {told} of {len(seeds)}")


def without_twice(poses: PoseSet) -> PoseSet:
    """The same without what comes twice per turn."""
    assert poses.ring is not None
    sd = poses.ring.sd.copy()
    sd[:, 1] = np.nan
    return replace(poses, ring=replace(poses.ring, sd=sd))


def study_twice_per_turn(tilt_deg: float, seeds: range) -> None:
    """Print what the rows of the waves twice per turn do for effects of attitude.

    By how much they lower the sds, and, of evenings with such an effect of ordinary size and with
    none, how often its class is named with and without them, and the rms deviation in stated sds.
    """
    for name, size in (("quadratic", 2.5e-4), ("asymmetry", 1e-3), ("cubic", 1.2e-5), ("", 0.0)):
        named, wrong, ratio, z = np.zeros(2, int), np.zeros(2, int), [], []
        model = Model.of([*BASE, name] if name else BASE)
        for seed in seeds:
            drawn = size * np.random.default_rng([FRESH + seed, 5]).standard_normal(3)
            hidden = (Hidden(name, "accelerometer", drawn),) if name else ()
            sensor, _ = unit_of(seed)
            design = replace(tilted_design(tilt_deg, sensor, MOTION), sample_rate_hz=50.0)
            table = leaning(design.turntable, tilt_deg, seed)
            poses, _, specs = tilted_pose_sets(
                simulate(replace(design, turntable=table), FRESH + seed, hidden))
            both = poses, without_twice(poses)
            for i, some in enumerate(both):
                said = assess(some, Model.of(BASE), specs[0]).diagnosis
                named[i] += bool(said.names) and name in (*said.names, *said.group)
                wrong[i] += bool(said.names) and name not in (*said.names, *said.group)
            if name:
                fits = [fit(some, model) for some in both]
                of_effect = model.slices()[name]
                sds = [np.sqrt(np.diag(one.cov)[of_effect]) for one in fits]
                ratio.append(sds[0] / sds[1])
                z.append((fits[0].theta[of_effect] - drawn) / sds[0])
        of_sds = (f"sds times {np.median(ratio):.2f}, rms z {np.sqrt(np.mean(np.square(z))):.2f}, "
                  f"named {named[0]} of {len(seeds)} ({named[1]} without these rows), " if name
                  else "")
        print(f"{tilt_deg:g}°, {name or 'nothing'}: {of_sds}wrong names {wrong[0]} ({wrong[1]})",
              flush=True)


def study_gyroscope_twice_per_turn(tilt_deg: float) -> None:
    """Print by how much such rows of a gyroscope, which has none, would lower its sds."""
    to_twice = TO_WAVES[2:]
    _, poses, _ = pose_sets(evening(0, tilt_deg, hide=False)[0])
    for name in ("g_sensitivity", "g_squared_sensitivity", "quadratic"):
        fitted = fit(poses, Model.of([*BASE, name]))
        waves, ring = fitted.equations.waves, poses.ring
        assert waves is not None
        assert ring is not None
        _, columns, _ = waves.points.corrected(fitted.theta, fitted.shapes)
        rows = np.tensordot(columns.reshape(-1, ANGLES, *columns.shape[-2:]), to_twice, (1, 1))
        axis = poses.reading[ring.place]  # what is along it is wow
        axis /= np.linalg.norm(axis, axis=1, keepdims=True)
        rows -= np.einsum("wi,wj,wjpc->wipc", axis, axis, rows)
        rows = np.moveaxis(rows / ring.sd[:, 0, :, None, None], 2, -1)
        rows = rows.reshape(-1, fitted.model.size)
        more = np.linalg.inv(np.linalg.inv(fitted.cov) + rows.T @ rows)
        of_effect = fitted.model.slices()[name]
        ratio = np.sqrt(np.diag(more)[of_effect] / np.diag(fitted.cov)[of_effect])
        print(f"{tilt_deg:g}°, gyroscope {name}: sds times {ratio.min():.2f} to {ratio.max():.2f}",
              flush=True)


def deviations(
    found: TriadCalibration, truth: Parameters
) -> list[tuple[str, FloatArray, FloatArray]]:
    """Errors and sds of misalignment, bias and scale, the last relative."""
    rows = []
    for i, name in enumerate(("misalignment_rad", "bias_counts", "scale_counts_per_unit")):
        per = getattr(truth, name) if i == 2 else np.ones(3)
        error = (getattr(found.parameters, name) - getattr(truth, name)) / per
        rows.append((f"{found.triad} {name}", error, found.parameters.sd[i] / per))
    return rows


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sessions", choices=("evening", "three_minutes", "twice"),
                        default="evening")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--poses", type=int, choices=(9, 36), default=9)
    parser.add_argument("--tilt", type=float, nargs="*", default=[0.3, 2.0, 5.0, 10.0, 20.0])
    parser.add_argument("--tug", type=float, default=0.0)
    parser.add_argument("--first", type=int, default=0)
    asked = parser.parse_args()
    for i, tilt in enumerate(asked.tilt):
        seeds = range(asked.first + 1000 * i, asked.first + 1000 * i + asked.seeds)
        if asked.sessions == "twice":
            study_twice_per_turn(tilt, seeds)
            study_gyroscope_twice_per_turn(tilt)
            continue
        if asked.sessions == "three_minutes":
            study_three_minutes(tilt, seeds, asked.poses, asked.tug)
            continue
        for hide in (True, False):
            study_evenings(tilt, hide, seeds, asked.tug)


if __name__ == "__main__":
    main()
