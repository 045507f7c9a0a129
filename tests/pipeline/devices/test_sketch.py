"""The shipped Arduino sketch, compiled for this computer with a board and a chip of paper."""

import shutil
import subprocess

import numpy as np
import pytest

from pipeline.devices.mpu6050_text import Mpu6050TextParser
from tests.paths import DATA
from tests.pipeline.devices.real_streams import begun

SKETCH = (DATA / "arduino" / "turntable_mpu6050"
          / "turntable_mpu6050.ino")

#: As much of Arduino's API as the sketch uses. The chip counts 1000 samples a second divided by
#: SMPLRT_DIV, and answers a word that tells its number in every axis.
BOARD = r"""
#include <cstdint>
#include <cstdio>
#include <cstring>
#define F(text) text
static uint32_t now_us = 4294000000u;  // wraps after a second
inline uint32_t micros() { return now_us; }
inline void delay(uint32_t ms) { now_us += 1000 * ms; }
struct SerialPort {
  void begin(uint32_t) {}
  void println(const char *text) { std::printf("%s\r\n", text); }
} Serial;
struct Chip {
  uint8_t reg[128] = {0}; uint8_t at = 0, sent = 0; uint32_t done = 0; uint8_t out[16]; int got = 0;
  void begin() {}
  void setClock(uint32_t) {}
  void beginTransmission(uint8_t) { sent = 0; }
  void write(uint8_t v) { if (sent++ == 0) at = v; else if (at < 128) reg[at++] = v; }
  uint8_t endTransmission(bool = true) { return 0; }
  uint8_t requestFrom(uint8_t, uint8_t count) {
    now_us += 300;
    uint32_t step = 1000u * (1 + reg[0x19]);
    static uint32_t elapsed = 0, last = now_us;
    elapsed += now_us - last; last = now_us;
    bool ready = elapsed / step > done;
    if (at == 0x3A) out[0] = ready;
    else if (at == 0x75) out[0] = 0x98;
    else if (at == 0x3B) {
      done = elapsed / step;
      for (int i = 0; i < 7; i++) {
        int16_t w = (int16_t)(i == 3 ? -3920 : (i + 1) * (i % 2 ? -4000 : 4000) + (int)(done % 7));
        out[2 * i] = (uint16_t)w >> 8; out[2 * i + 1] = w & 0xFF;
      }
    }
    got = 0;
    return count;
  }
  uint8_t read() { return out[got++]; }
} Wire;
"""
MAIN = """
int main() { setup(); for (int i = 0; i < 40000; i++) loop();
  return Wire.reg[0x1A] == 3 && Wire.reg[0x1B] == 0 && Wire.reg[0x1C] == 0 ? 0 : 1; }
"""


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    compiler = shutil.which("g++") or shutil.which("c++")
    if compiler is None:
        pytest.skip("there is no C++ compiler here to build the sketch with")
    folder = tmp_path_factory.mktemp("sketch")
    source = SKETCH.read_text(encoding="utf-8").replace("#include <Wire.h>", "")
    (folder / "sketch.cpp").write_text(BOARD + source + MAIN)
    subprocess.run([compiler, "-Wall", "-Wextra", "-Werror", "-o", folder / "sketch",
                    folder / "sketch.cpp"], check=True)
    return subprocess.run([folder / "sketch"], check=True, capture_output=True).stdout


def test_its_lines_are_read_whole_with_numbers_times_and_settings(printed: bytes) -> None:
    parser = begun(Mpu6050TextParser())
    samples = parser.feed(printed)
    assert len(samples) > 1000
    assert parser.bad == 0
    assert parser.settings == {"fs_a": 2, "fs_g": 250, "odr": 100}
    assert printed.count(b"#turntable v1 mpu6050 fs_a=2 fs_g=250 odr=100 id=0x98") >= 2
    words = np.array([(*s.accelerometer, *s.gyroscope) for s in samples])
    assert np.abs(words - np.array([4000, -8000, 12000, 20000, -24000, 28000])).max() < 7
    assert dict(samples[0].columns)["temperature_c"] == pytest.approx(25.0, abs=0.01)


def test_its_clock_wraps_and_its_samples_come_at_the_rate_it_states(printed: bytes) -> None:
    from pipeline.devices.sample import MICROS, Unwrap

    parser, unwrap = begun(Mpu6050TextParser()), Unwrap(MICROS)
    ticks = [sample.ticks or 0 for sample in parser.feed(printed)]
    assert min(np.diff(ticks)) < 0  # the wrap is in it
    total = [unwrap(tick) for tick in ticks]
    assert unwrap.restarts == 0
    assert np.diff(total).mean() == pytest.approx(10_000, rel=1e-3)


def test_the_longest_line_fits_its_buffer_and_the_line_speed(printed: bytes) -> None:
    longest = len("S,4294967295,4294967295," + ",".join(["-32768"] * 7) + "*FF\r\n")
    assert longest + 1 <= 96
    assert longest * 10 * 100 < 115200  # bits a second at 100 samples a second
    assert printed
