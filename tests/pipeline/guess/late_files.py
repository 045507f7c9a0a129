"""Logs that were thought of after the importer was written, and that it did not read at first."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.pipeline.guess.foreign_files import DEG, Foreign, G
from tests.pipeline.guess.hand_log import HandLog
from tests.pipeline.guess.text_rows import counts_of, si_rows, write_lines

TICKS = 2**32  #: of a counter, which then begins again


def movella_dot(folder: Path, log: HandLog) -> Foreign:
    """SampleTimeFine in microseconds, where an MTi's ticks at 10 kHz, and it wraps."""
    head = ["sep=,", "DeviceTag:,Xsens DOT 3", "OutputRate:,100Hz", "",
            "PacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,"]
    rows = [f"{i + 1},{(round(t * 1e6) + TICKS - 50_000_000) % TICKS},"
            + "".join(f"{v:.6f}," for v in (*a, *(w / DEG)))
            for i, (t, a, w) in enumerate(zip(log.time_s, log.acc, log.gyr, strict=True))]
    return Foreign([write_lines(folder / "Xsens DOT 3_D422CD00.csv", [*head, *rows])],
                   1.0, 1 / DEG)


def registers(folder: Path, log: HandLog) -> Foreign:
    """Sixteen bits in hexadecimal, as they stand in the sensor."""
    rows = [" ".join([str(round(t * 1000)), *(f"0x{v & 0xFFFF:04X}" for v in counts)])
            for t, counts in zip(log.time_s, np.clip(counts_of(log), -32768, 32767), strict=True)]
    return Foreign([write_lines(folder / "raw.log", ["t_ms AX AY AZ GX GY GZ", *rows])],
                   16384 / G, 131.072 / DEG)


def fortran(folder: Path, log: HandLog) -> Foreign:
    """Exponents with a D, and a C in front of the names."""
    rows = ["  ".join(f"{float(v):.7E}".replace("E", "D") for v in row) for row in si_rows(log)]
    head = "C  TIME/S  FX/(M/S2)  FY  FZ  WX/(RAD/S)  WY  WZ"
    return Foreign([write_lines(folder / "fort.21", [head, *rows])], 1.0, 1.0)


def spreadsheet(folder: Path, log: HandLog) -> Foreign:
    """Days since 1900, as a spreadsheet stores a date."""
    rows = [",".join([f"{46085.41666667 + t / 86400:.10f}", *(f"{v:.5f}" for v in (*a / G, *w))])
            for t, a, w in zip(log.time_s, log.acc, log.gyr, strict=True)]
    head = "Date,AccX [g],AccY [g],AccZ [g],GyroX [rad/s],GyroY [rad/s],GyroZ [rad/s]"
    return Foreign([write_lines(folder / "sheet.csv", [head, *rows])], 1 / G, 1.0)


def taking_turns(folder: Path, log: HandLog) -> Foreign:
    """Each row has the readings of one sensor, the cells of the other are empty."""
    rows = [row for t, *cells in si_rows(log)
            for row in (",".join([t, *cells[:3], "", "", ""]),
                        ",".join([f"{float(t) + 0.002:.4f}", "", "", "", *cells[3:]]))]
    return Foreign([write_lines(folder / "turns.csv", ["t,ax,ay,az,gx,gy,gz", *rows])])


LATE: dict[str, Callable[[Path, HandLog], Foreign]] = {
    tool.__name__: tool for tool in (movella_dot, registers, fortran, spreadsheet, taking_turns)
}
