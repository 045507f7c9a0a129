"""Classes of sensors as their data sheets have them: range, resolution, noise density, filter.

What tells a coarse quiet converter from a log that froze, and slow noise from a sensor that was
moved, hangs on noise over step and on how long noise stays correlated. The classes span both.
"""

from dataclasses import dataclass, replace

import numpy as np

from tests.world.imu import G_STANDARD, Sensor, Triad, mpu6050, mti

NOISE_BANDWIDTH = np.pi / 2  #: of a first-order low pass, in units of its corner


@dataclass(frozen=True)
class SensorClass:
    """One class.

    Parameters
    ----------
    full_scale_g, full_scale_deg_s : float
    bits : tuple of int
        Of the accelerometer's and of the gyroscope's converter.
    noise_ug, noise_mdeg_s : float
        Densities, µg/√Hz and m°/s/√Hz.
    filter_hz : float
        Corner of the low pass.
    slow : tuple of float
        Slow noise of both triads, sd in units of the white noise of a sample.
    slow_tau_s : float
    """

    full_scale_g: float
    full_scale_deg_s: float
    bits: tuple[int, int]
    noise_ug: float
    noise_mdeg_s: float
    filter_hz: float = 42.0
    slow: tuple[float, float] = (0.2, 0.2)
    slow_tau_s: float = 0.5

    def sensor(self, name: str, sample_rate_hz: float) -> Sensor:
        """A unit of the class; its axes and offsets are those of the simulated MPU-6050."""
        unit = mpu6050()
        bandwidth = min(self.filter_hz * NOISE_BANDWIDTH, sample_rate_hz / 2)
        noise = (self.noise_ug * 1e-6 * G_STANDARD, np.deg2rad(self.noise_mdeg_s * 1e-3))
        scale = (self.full_scale_g * G_STANDARD, np.deg2rad(self.full_scale_deg_s))
        triads = [
            self._triad(triad, bits, full, density * np.sqrt(bandwidth), slow, sample_rate_hz)
            for triad, bits, full, density, slow in zip(
                (unit.accelerometer, unit.gyroscope), self.bits, scale, noise, self.slow,
                strict=True)
        ]
        return replace(unit, name=name, accelerometer=triads[0], gyroscope=triads[1])

    def _triad(self, triad: Triad, bits: int, full_scale: float, noise: float, slow: float,
               sample_rate_hz: float) -> Triad:
        gain = triad.gain * (2 ** (bits - 1) / full_scale) / (2**15 / triad.full_scale)
        corner = self.filter_hz / sample_rate_hz
        keep = np.exp(-2 * np.pi * corner)
        white = noise * np.sqrt((1 + keep) / (1 - keep)) * float(gain.mean())  # ahead of the filter
        return replace(
            triad, gain=gain, offset=np.rint(triad.offset * gain / triad.gain), bits=bits,
            full_scale=full_scale, white_sd=float(white),
            slow_sd=float(slow * noise * gain.mean()), slow_tau_s=self.slow_tau_s,
            bandwidth_hz=self.filter_hz)


CLASSES: dict[str, SensorClass] = {
    "MPU-6050, ±2 g, 250 °/s": SensorClass(2, 250, (16, 16), 400, 5),
    "MPU-6050, ±16 g, 2000 °/s": SensorClass(16, 2000, (16, 16), 400, 5),
    "MPU-6050, filter 5 Hz": SensorClass(2, 250, (16, 16), 400, 5, filter_hz=5.0),
    "MPU-9250, ±8 g, 1000 °/s": SensorClass(8, 1000, (16, 16), 300, 10),
    "LSM6DS3, ±2 g, 245 °/s": SensorClass(2, 245, (16, 16), 90, 7),
    "LSM9DS1, ±16 g, 2000 °/s": SensorClass(16, 2000, (16, 16), 150, 8),
    "BMI160, ±4 g, 500 °/s": SensorClass(4, 500, (16, 16), 180, 7),
    "ICM-42688, ±16 g, 2000 °/s": SensorClass(16, 2000, (16, 16), 70, 2.8),
    "ADXL345 and ITG-3200, 10 bit, ±2 g": SensorClass(2, 2000, (10, 16), 290, 30, filter_hz=20.0),
    "LIS331 and L3G, 12 bit, ±2 g": SensorClass(2, 500, (12, 16), 220, 30),
    "analogue, 10 bit": SensorClass(3, 300, (10, 10), 280, 35, filter_hz=25.0),
    "filtered to 1 Hz": SensorClass(2, 250, (16, 16), 400, 5, filter_hz=1.0),
    "slow noise over 4 s": SensorClass(2, 250, (16, 16), 400, 5, slow=(0.6, 0.6), slow_tau_s=4.0),
}
"""Parts and settings; densities and filters of the data sheets, the last two as hobbyists log."""


def sensors(sample_rate_hz: float) -> dict[str, Sensor]:
    """A unit of every class, and the MTi."""
    units = {name: each.sensor(name, sample_rate_hz) for name, each in CLASSES.items()}
    return {"Xsens MTi": mti(), **units}
