"""A configuration that has every key of the contract, and what reading a changed one gives."""

from pathlib import Path

import pytest

from pipeline.config.load import Config, load_config
from pipeline.errors import ConfigError

GOOD = """\
title: MTi on a 16 rpm record player
sensor:
  name: Xsens MTi
  accelerometer: {full_scale_m_s2: 50, bits: 16, encoding: offset-binary}
  gyroscope: {full_scale_deg_s: 150, bits: 16, encoding: offset-binary}
rate:
  slow:
    video: clip.mp4
    nominal_rpm: 16.667
    timebase: {source: constant, fps: 15}
    model: [constant_rate, once_per_rev]
    plate: {centre_px: [240, 180], radii_px: [150, 140.5]}
  33: {rate_rad_s: 3.4907, sd_rad_s: 2e-4}
site: {latitude_deg: 40.85, height_m: 20, gravity_m_s2: 9.80267, sd_m_s2: 5e-5}
accelerometer:
  poses: acc/pose_*.csv          # in natural order
  model: [bias, scale, misalignment, column:supply_v, mine]
  solver: paper
gyroscope:
  runs:
    - {poses: [gyr/b.csv, gyr/a.csv], rate: slow}
    - {poses: {files: 'run/?.csv', columns: [gyr_x, gyr_y, gyr_z], sample_rate_hz: 100}, rate: 33}
    - poses:
        log: [long/a.csv, long/b.csv]
        columns: [[time_s, acc_x, acc_y, acc_z], [time_s, gyr_x, gyr_y, gyr_z]]
        find: still
      rate: stopped
certificate:
  accelerometer: {bias_counts: [1, 2, 3], scale_counts_per_unit: [4, 5, 6]}
effects:
  mine: {expression: temperature_c ** 2, per: axis, unit: m/s² per °C²}
installation: {log: gyr/a.csv}
record: {device: xsens-mti, port: COM3, poses: 18}
covariates: [temperature_c, supply_v]
"""


def load(folder: Path, text: str) -> Config:
    path = folder / "config.yaml"
    path.write_text(text, encoding="utf-8")
    return load_config(path)


def problems(folder: Path, text: str) -> list[str]:
    """The paragraphs without the folder's name."""
    with pytest.raises(ConfigError) as caught:
        load(folder, text)
    return [says.removeprefix(f"{folder}/") for says in caught.value.problems]
