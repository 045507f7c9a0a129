"""Lines of the project's own sketch (data/arduino): numbered, time-stamped, with a checksum.

    #turntable v1 mpu6050 fs_a=2 fs_g=250 odr=100
    S,n,micros,ax,ay,az,gx,gy,gz,temp*crc8

``n`` counts samples from 0, ``micros`` is the board's microsecond clock (32 bits), readings and
temperature are the chip's words. The checksum is CRC-8 (polynomial x^8 + x^2 + x + 1, start 0) of
everything before the ``*``, as two hexadecimal digits.
"""

import re

from calib.poses.imu_log import TEMPERATURE
from pipeline.devices.sample import Sample

HEADER = "#turntable "
WORDS_PER_K, WORD_0_C = 340, 36.53  #: facts of the MPU-6050's temperature: steps, °C at word 0
POLYNOMIAL = 0x07  #: polynomial of the CRC-8 above, without its leading term

_WORD = r"(-?\d{1,5})"
_LINE = re.compile(rf"(S,(\d{{1,10}}),(\d{{1,10}}),{','.join([_WORD] * 7)})\*([0-9A-Fa-f]{{2}})")
_SETTING = re.compile(r"(\w+)=([0-9.]+)(?!\S)")


def _crc_table() -> tuple[int, ...]:
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = (byte << 1) ^ (POLYNOMIAL if byte & 0x80 else 0)
        table.append(byte & 0xFF)
    return tuple(table)


_CRC = _crc_table()


def crc8(data: bytes) -> int:
    """CRC-8 of ``data``.

    >>> hex(crc8(b"123456789"))
    '0xf4'
    """
    crc = 0
    for byte in data:
        crc = _CRC[crc ^ byte]
    return crc


def sketch_line(n: int, micros: int, words: tuple[int, ...]) -> str:
    """The line of one sample; ``words`` are ax, ay, az, gx, gy, gz, temperature."""
    body = f"S,{n},{micros},{','.join(map(str, words))}"
    return f"{body}*{crc8(body.encode()):02X}"


def is_sketch_line(line: str) -> bool:
    """Whether the line is, or once was, one of the sketch's samples."""
    return line.startswith("S,")


def parse_sketch_line(line: str) -> Sample | None:
    """The sample of one line, None where it is damaged."""
    match = _LINE.fullmatch(line)
    if match is None or crc8(match[1].encode()) != int(match[11], 16):
        return None
    ax, ay, az, gx, gy, gz, temperature = (int(word) for word in match.groups()[3:10])
    return Sample((ax, ay, az), (gx, gy, gz), int(match[3]),
                  ((TEMPERATURE, mpu6050_temperature_c(temperature)),))


def mpu6050_temperature_c(word: int) -> float:
    """Temperature of an MPU-6050 in °C (its register map, section 4.18)."""
    return round(word / WORDS_PER_K + WORD_0_C, 3)


def mpu6050_temperature_word(temperature_c: float) -> int:
    """The word that an MPU-6050 sends for a temperature."""
    return round((temperature_c - WORD_0_C) * WORDS_PER_K)


def header_settings(line: str) -> dict[str, float]:
    """The settings ``name=value`` of the sketch's first line."""
    return {name: float(value) for name, value in _SETTING.findall(line) if value.count(".") < 2
            and value != "."}
