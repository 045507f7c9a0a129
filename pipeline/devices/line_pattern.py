"""Parser of lines of text in a byte stream: by any pattern, and those of the project's own sketch.

Names in braces stand for numbers, everything else for itself; a blank stands for any blanks, or
none, but between two numbers for one blank at least. ``{skip}`` is anything up to the next comma,
semicolon or blank. Times are ``{time_s}``, ``{time_ms}`` or ``{time_us}``, ``{counter}`` counts
samples; further names become columns.

    #turntable v1 mpu6050 fs_a=2 fs_g=250 odr=100
    S,n,micros,ax,ay,az,gx,gy,gz,temp*crc8

``n`` counts samples from 0, ``micros`` is the board's microsecond clock (32 bits), readings and
temperature are the chip's words. The checksum is CRC-8 (polynomial x^8 + x^2 + x + 1, start 0) of
everything before the ``*``, as two hexadecimal digits.
"""

import re
from dataclasses import dataclass

from calib.poses.imu_log import TEMPERATURE
from pipeline.devices.sample import AS_LABELLED, CLOCKS, Parser, Sample, clock_among, sample_of
from pipeline.logs.columns import SKIP, missing_columns

LONGEST_LINE = 1000  #: bytes; longer than the header of any logger met, and no line has no end


class LineReader:
    """Splits a stream into lines; text before the first line end is an incomplete line.

    Attributes
    ----------
    bad : int
        Lines that were no text, or too long.
    """

    def __init__(self) -> None:
        self.bad = 0
        self._rest = bytearray()
        self._discard = True

    def feed(self, data: bytes) -> list[str]:
        """The whole lines that ``data`` completes, without their ends."""
        *ended, rest = (bytes(self._rest) + data).split(b"\n")
        lines = [line for piece in ended if (line := self._line(piece)) is not None]
        if len(rest) > LONGEST_LINE:
            self.bad += not self._discard
            self._discard, rest = True, b""
        self._rest = bytearray(rest)
        return lines

    def _line(self, piece: bytes) -> str | None:
        if self._discard:  # the end of a line whose beginning is missing
            self._discard = False
            return None
        text = piece.decode("latin-1").rstrip("\r\0")
        if len(piece) > LONGEST_LINE or not (
                text.isascii() and text.replace("\t", " ").isprintable()):
            self.bad += 1
            return None
        return text


PLACE = re.compile(r"\{([^{}]*)\}")
NUMBER = r"([-+]?\d{1,12}(?:\.\d{0,12})?(?:[eE][-+]?\d{1,2})?)"
ANYTHING = r"([^,;\s]{0,60})"


@dataclass(frozen=True)
class LinePattern:
    """A pattern of a line, and its meaning; ``head`` is the text before its first number."""

    text: str
    names: tuple[str, ...]
    head: re.Pattern[str]
    whole: re.Pattern[str]

    @classmethod
    def of(cls, text: str) -> "LinePattern":
        """Read a pattern."""
        first, *pieces = PLACE.split(text)
        numbers = [ANYTHING if name == SKIP else NUMBER for name in pieces[::2]]
        between = [r"\s+" if piece.isspace() and i < len(numbers) - 1 else _literal(piece)
                   for i, piece in enumerate(pieces[1::2])]
        rest = "".join(number + after for number, after in zip(numbers, between, strict=True))
        return cls(text, tuple(pieces[::2]), re.compile(rf"\s*{_literal(first)}"),
                   re.compile(rf"\s*{_literal(first)}{rest}\s*"))

    @classmethod
    def stated(cls, text: str) -> "LinePattern":
        """Read a pattern that must describe a whole sample.

        Raises
        ------
        ValueError
            It names no whole triad, a name twice, or two numbers with nothing between them.
        """
        names = tuple(PLACE.findall(text))
        example = "as in '{time_ms},{acc_x},{acc_y},{acc_z},{gyr_x},{gyr_y},{gyr_z}'"
        if wrong := [name for name in names if not re.fullmatch(r"[A-Za-z_]\w*", name)]:
            raise ValueError(f"'{{{wrong[0]}}}' is no name of a column; write names in braces, "
                             f"{example}")
        if "}{" in text:
            raise ValueError(f"nothing separates two of its numbers; write what stands between "
                             f"them, {example}")
        if lacks := missing_columns(names):
            raise ValueError(f"{lacks}; write every number of the line in braces, {example}")
        if sum(name in CLOCKS for name in names) > 1:
            raise ValueError("it names more than one time or counter; keep the finer one and "
                             "write {skip} for the other")
        return cls.of(text)

    def values(self, line: str) -> dict[str, float] | None:
        """The numbers in a line by their names; None where it does not fit."""
        match = self.whole.fullmatch(line)
        return None if match is None else {
            name: float(text) for name, text in zip(self.names, match.groups(), strict=True)
            if name != SKIP}


def _literal(text: str) -> str:
    return "".join(r"\s*" if part.isspace() else re.escape(part)
                   for part in re.split(r"(\s+)", text) if part)


class LinePatternParser(Parser):
    """Samples from lines of one pattern."""

    def __init__(self, pattern: LinePattern) -> None:
        stamp = clock_among(pattern.names)
        super().__init__(LineReader(), AS_LABELLED, CLOCKS[stamp][0] if stamp else None)
        self._pattern = pattern
        self._fits = False

    def _sample(self, line: str) -> Sample | None:
        values = self._pattern.values(line)
        if values is None:
            self._damaged += bool(line.strip())
            self.advice = "" if self._fits else (
                f"lines come, but none fits `pattern`; the last is '{line[:80]}', the pattern "
                f"'{self._pattern.text}'")
            return None
        self._fits, self.advice = True, ""
        return sample_of(values)


HEADER = "#turntable "
WORDS_PER_K, WORD_0_C = 340, 36.53  #: facts of the MPU-6050's temperature: steps, °C at word 0
POLYNOMIAL = 0x07  #: polynomial of the CRC-8 above, without its leading term

_WORD = r"(-?\d{1,5})"
_LINE = re.compile(rf"(S,(\d{{1,10}}),(\d{{1,10}}),{','.join([_WORD] * 7)})\*([0-9A-Fa-f]{{2}})")
_SETTING = re.compile(r"(\w+)=([0-9.]+)(?!\S)")


def crc8(data: bytes) -> int:
    """CRC-8 of ``data``.

    >>> hex(crc8(b"123456789"))
    '0xf4'
    """
    crc = 0
    for byte in data:
        crc = _REMAINDERS[crc ^ byte]
    return crc


def _remainder(byte: int) -> int:
    for _ in range(8):
        byte = (byte << 1 ^ POLYNOMIAL * (byte >> 7)) & 0xFF
    return byte


_REMAINDERS = bytes(map(_remainder, range(256)))


def sketch_line(n: int, micros: int, words: tuple[int, ...]) -> str:
    """The line of one sample; ``words`` are ax, ay, az, gx, gy, gz, temperature."""
    body = f"S,{n},{micros},{','.join(map(str, words))}"
    return f"{body}*{crc8(body.encode()):02X}"


def parse_sketch_line(line: str) -> Sample | None:
    """The sample of one line, None where it is damaged."""
    match = _LINE.fullmatch(line)
    if match is None or crc8(match[1].encode()) != int(match[11], 16):
        return None
    ax, ay, az, gx, gy, gz, warmth = (int(word) for word in match.groups()[3:10])
    return Sample((ax, ay, az), (gx, gy, gz), int(match[3]),
                  ((TEMPERATURE, round(warmth / WORDS_PER_K + WORD_0_C, 3)),))


def mpu6050_temperature_word(temperature_c: float) -> int:
    """The word that an MPU-6050 sends for a temperature."""
    return round((temperature_c - WORD_0_C) * WORDS_PER_K)


def header_settings(line: str) -> dict[str, float]:
    """The settings ``name=value`` of the sketch's first line."""
    return {name: float(value) for name, value in _SETTING.findall(line) if value.count(".") < 2
            and value != "."}
