"""A magnetometer calibrated against a stated field: parameters, stated sds and verdicts.

Sessions of the paper's design whose 18 poses at rest log the field of the Earth too, with nothing
hidden and with a zero that follows the temperature, which is then added. Written to a folder and
run as a user does.

Run: python -m tests.bench.study_magnetometer --seeds 40 --first 40000
"""

import argparse
import contextlib
import io
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.sessions import FIELD_SD_UT, magnetometer_session, pipeline, results_in
from tests.world.imu import FloatArray
from tests.world.magnetometer import Magnetometer

PER_KELVIN_UT = 0.1  #: sd over the axes of what is hidden


def z_of(results: dict[str, object], sensor: Magnetometer) -> FloatArray:
    """Errors of biases and of scales in their stated sds, (2, 3)."""
    found, sds = results["parameters"], results["sd"]
    assert isinstance(found, dict)
    assert isinstance(sds, dict)
    gain = np.diag(np.linalg.qr(np.linalg.inv(sensor.iron))[1])
    truth = {"bias_counts": sensor.offset_ut * sensor.counts_per_ut,
             "scale_counts_per_unit": sensor.counts_per_ut / np.abs(gain)}
    return np.array([(np.array(found[key]) - true) / np.array(sds[key])
                     for key, true in truth.items()])


def main() -> int:
    """Print the rms of the errors in stated sds, and what the verdicts were."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--first", type=int, default=40_000)
    arguments = parser.parse_args()
    for hidden in (False, True):
        errors, verdicts = [], []
        for seed in range(arguments.first, arguments.first + arguments.seeds):
            rng = np.random.default_rng([seed, 3])
            sensor = Magnetometer(offset_ut=20 * rng.standard_normal(3),
                                  field_ut=45 + 5 * rng.random(), dip_deg=60 * rng.random())
            known = replace(sensor)  # what the session states is off by a draw of its sd
            if hidden:
                sensor = replace(sensor, per_kelvin=PER_KELVIN_UT * rng.standard_normal(3))
            stated = replace(sensor, field_ut=known.field_ut + FIELD_SD_UT * rng.standard_normal())
            with tempfile.TemporaryDirectory() as place, \
                    contextlib.redirect_stdout(io.StringIO()):
                config = magnetometer_session(Path(place), seed, sensor)
                text = config.read_text(encoding="utf-8")
                config.write_text(text.replace(f"field_ut: {sensor.field_ut}",
                                               f"field_ut: {stated.field_ut}"), encoding="utf-8")
                if pipeline("run", config, "--quiet") != 0:
                    verdicts.append("refused")
                    continue
                diagnosis = results_in(Path(place) / "config.run")["magnetometer"]["diagnosis"]
                verdicts.append(diagnosis["name"] or diagnosis["verdict"])
                if hidden:
                    pipeline("add", config, "magnetometer.temperature_bias", "--anyway", "--quiet")
                results = results_in(Path(place) / "config.run")["magnetometer"]
            errors.append(z_of(results, sensor))
        bias, scale = np.sqrt(np.mean(np.square(errors), axis=(0, 2)))
        counts = {name: verdicts.count(name) for name in dict.fromkeys(verdicts)}
        print(f"{'temperature_bias hidden' if hidden else 'nothing hidden':24} "
              f"rms z of biases {bias:.2f}, of scales {scale:.2f}; {counts}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
