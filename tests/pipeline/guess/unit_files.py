"""Tables that differ in their units, languages, numbers, and in what stands beside the readings."""

import struct

import numpy as np

from tests.pipeline.guess.foreign import (
    AXES,
    DEG,
    G,
    Sample,
    Writer,
    comma,
    pose_rows,
    rows,
)
from tests.pipeline.guess.table_files import (
    attitude,
    begin_again,
    cut_a_line,
    event_lines,
    lose_readings,
    lose_samples,
)

PER_COUNT = {"acc": 16384 / G, "gyr": 131.072 / DEG}
MILLI_G, PER_G, PER_DEG = 1000 / G, 1 / G, 1 / DEG


def french(sample: Sample) -> str:
    """Narrow blanks between thousands, and decimal commas."""
    return ";".join(f"{float(cell):,.2f}".replace(",", "\u202f").replace(".", ",")
                    for cell in (1000 * float(sample.cells[0]), *sample.cells[1:]))


def decimals(cell: str) -> str:
    """Thousands with a separator, in quotes."""
    return f'"{float(cell):,.1f}"' if abs(float(cell)) >= 1000 else f"{float(cell):.1f}"


def state(sample: Sample, channels: range) -> str:
    return ",".join(f"{(37 * sample.i + j) % 11}" for j in channels)


UNITS: dict[str, Writer] = {
    "milli_g": rows(
        "log.csv", "timestamp_us;acc_x_mg;acc_y_mg;acc_z_mg;gyr_x_dps;gyr_y_dps;gyr_z_dps;temp",
        lambda s: comma(f"{s.t * 1e6:.9g};{s.a:;.9g};{s.w:;.9g};25.5"), MILLI_G, PER_DEG),
    # negative powers, as a paper writes units
    "powers": rows(
        "si.csv", "Zeit [s];ax [ms-2];ay [ms-2];az [ms-2];wx [rad·s⁻¹];wy [rad·s⁻¹];wz [rad·s⁻¹]",
        lambda s: f"{s.t:.3f};{s.a:;.5f};{s.w:;.5f}"),
    "powers_behind_names": rows(
        "si.csv", "time_s,ax_ms2,ay_ms2,az_ms2,gx_rads,gy_rads,gz_rads",
        lambda s: f"{s.t:.3f},{s.a:,.5f},{s.w:,.5f}"),
    # whole milli-g and a row number; a preamble, semicolons, decimal commas
    "german_excel_mg": rows(
        "Messung 1.csv", "Messprotokoll\nGerät: X1\n\nNr.;Zeit [s];Beschl. X [mg];Beschl. Y [mg];"
        "Beschl. Z [mg];Drehrate X [°/s];Drehrate Y [°/s];Drehrate Z [°/s];Temperatur [°C]",
        lambda s: comma(f"{s.i + 1};{s.t:.2f};{s.a:;.0f};{s.w:;.3f};25.3"), MILLI_G, PER_DEG,
        encoding="utf-8-sig", end="\r\n"),
    "spanish": rows("datos.csv", "tiempo_ms;aceleracion_x_g;aceleracion_y_g;aceleracion_z_g;"
                    "giro_x_dps;giro_y_dps;giro_z_dps", lambda s: (
                        f"{1000 * s.t:.0f};{s.a:;.5f};{s.w:;.5f}"), PER_G, PER_DEG),
    "korean": rows("측정.csv", "시간(초),가속도X(m/s²),가속도Y(m/s²),가속도Z(m/s²),각속도X(deg/s),"
                   "각속도Y(deg/s),각속도Z(deg/s)", lambda s: s.s, gyr=PER_DEG, encoding="cp949"),
    "japanese": rows("sensor.csv", "時刻[s],加速度X[G],加速度Y[G],加速度Z[G],角速度X,角速度Y,"
                     "角速度Z", lambda s: f"{s.t:.5f},{s.a:,.5f},{s.w:,.5f}", PER_G, PER_DEG,
                     encoding="shift_jis"),
    # names in the code page of China, dates, and a name of the device that holds a number
    "witmotion_chinese": rows(
        "data.txt", "时间\t设备名称\t加速度X(g)\t加速度Y(g)\t加速度Z(g)\t角速度X(°/s)\t"
        "角速度Y(°/s)\t角速度Z(°/s)", lambda s: (
            f"2026-03-04 14:05:{s.t:06.3f}\tWT901(f1:22)\t{s.a:\t.4f}\t{s.w:\t.4f}"), PER_G,
        PER_DEG, encoding="gb18030"),
    # LSM6DS at ±4 g and ±500 °/s: 0.122 mg and 17.5 m°/s per count
    "sensitivities_of_st": rows("lsm6ds.csv", f"micros,{AXES}", lambda s: (
        f"{s.t * 1e6:.0f},{s.c:,d}"), 1 / 0.122e-3 / G, 1 / 0.0175 / DEG),
    # 100 counts per m/s² and 16 per °/s, which lie close to 16.384
    "bno055": rows("bno.txt", "millis aX aY aZ gX gY gZ", lambda s: (
        f"{1000 * s.t:.0f} {s.c: d}"), 100.0, 16 / DEG),
    # whole mg without a unit beside a gyroscope that is no BNO055's
    "whole_mg": rows("board.csv", "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z", lambda s: (
        f"{s.t:.3f},{s.c:,d}"), MILLI_G, 32.768 / DEG),
    "micro_g": rows("fog.csv", "t[s];a_x[µg];a_y[µg];a_z[µg];w_x[°/h];w_y[°/h];w_z[°/h]",
                    lambda s: f"{s.t:.3f};{s.a:;.0f};{s.w:;.0f}", 1e6 / G, 3600 / DEG),
    "feet": rows("test 4.csv", "Time,Ax (ft/s^2),Ay (ft/s^2),Az (ft/s^2),P (deg/s),Q (deg/s),"
                 "R (deg/s)", lambda s: s.s, 1 / 0.3048, PER_DEG),
    # cm/s², as seismologists have it
    "gals": rows("station.csv", "time [s],acc_x [cm/s^2],acc_y [cm/s^2],acc_z [cm/s^2]",
                 lambda s: f"{s.t:.3f},{s.a:,.3f}", 100.0, None),
    "revolutions": rows("spin.csv", "t_s,ax_g,ay_g,az_g,gx_rpm,gy_rpm,gz_rpm", lambda s: s.s,
                        PER_G, 30 / np.pi),
    "named_directions": rows(
        "vehicle.csv", "Time (s),Forward (g),Left (g),Up (g),Roll rate (deg/s),Pitch rate (deg/s),"
        "Yaw rate (deg/s)", lambda s: s.s, PER_G, PER_DEG),
    "aerospace": rows("flight.csv", "TIME [s],p [rad/s],q [rad/s],r [rad/s],nx [g],ny [g],nz [g]",
                      lambda s: f"{s.t:.3f},{s.w:,.6f},{s.a:,.6f}", PER_G),
    # Gx is the force in g along x, and Rx the rate about it
    "g_force": rows("recorder.csv", "Time,Gx,Gy,Gz,Rx,Ry,Rz",
                    lambda s: f"{s.t:.5f},{s.a:,.5f},{s.w:,.5f}", PER_G, PER_DEG),
    # a row number, columns without names, units before the axis, a comma at the end
    "units_inside": rows("DATA.CSV", "#,T[S],,A[MG]X,A[MG]Y,A[MG]Z,,W[DPS]X,W[DPS]Y,W[DPS]Z,",
                         lambda s: f"{s.i},{s.t:.3f},,{s.a:,.6f},,{s.w:,.6f},", MILLI_G, PER_DEG,
                         end="\r\n"),
    # a header that was left as it was when the numbers were converted
    "units_that_cannot_be": rows("converted.csv", "time_ms,ax_mg,ay_mg,az_mg,gx_dps,gy_dps,gz_dps",
                                 lambda s: s.s, PER_G, PER_DEG),
    # a file for each rest: nothing turns gravity, and the unit stands in the second line alone
    "units_below_known_names": pose_rows(
        "p{}.csv", "time,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z\nms,g,g,g,cdps,cdps,cdps",
        lambda s: f"{1000 * s.t:.5f},{s.a:,.5f},{s.w:,.5f}", PER_G, 100 / DEG),
    # Grafana: labels with numbers in the names, units in the cells
    "series_with_labels": pose_rows(
        "p{}.csv", ",".join(["Time", *(f"{name}_{axis} {{board=esp32-1}}" for name in ("acc", "gyr")
                                       for axis in "xyz")]), lambda s: (
            f"2024-03-11 10:11:{s.t:06.3f},{s.a: g,.4f} g,{s.w: cdps,.4f} cdps"), PER_G, 100 / DEG),
    "units_in_cells": rows("display.txt", "time, accX, accY, accZ, gyrX, gyrY, gyrZ", lambda s: (
        f"{s.t:.2f}s, {s.a:g, .4f}g, {s.w:°/s, .3f}°/s"), PER_G, PER_DEG),
    "fahrenheit": rows(  # and columns in no order
        "log.csv", "gz,ay,temp_F,gx,az,gy,ax,time_s", lambda s: "{6},{2},77.5,{4},{3},{5},{1},{0}"
        .format(*s.cells), PER_G, PER_DEG),
    # an MTi's raw counts in a file for each sensor are in ``layout_files``
}

NUMBERS: dict[str, Writer] = {
    # sixteen bits in hexadecimal, as they stand in the sensor
    "registers": rows("raw.log", "t_ms AX AY AZ GX GY GZ", lambda s: (
        f"{1000 * s.t:.0f} " + " ".join(f"0x{v & 0xFFFF:04X}" for v in s.c16)), **PER_COUNT),
    # without 0x, and some look like decimal numbers, as do the times
    "bare_hexadecimal": rows("hex.csv", f"t_ms,{AXES}", lambda s: (
        f"{1000 * s.t:.0f}," + ",".join(f"{v & 0xFFFF:04X}" for v in s.c)), **PER_COUNT),
    # `Serial.print(ax, HEX)`: negative numbers have eight digits, small ones few
    "sign_extended": rows("com5.txt", "", lambda s: (
        f"{1000 * s.t:.0f}," + ",".join(f"{v & 0xFFFFFFFF:X}" for v in s.c)), **PER_COUNT),
    # `Serial.print(*(uint32_t*)&ax, HEX)`: numbers of IEEE 754, and a clock in whole numbers
    "floats_in_hexadecimal": rows("port.txt", f"millis,{AXES}", lambda s: (
        f"{round(1000 * s.t):X}," + ",".join(struct.pack(">f", v).hex().upper().lstrip("0")
                                             for v in (*s.a, *s.w)))),
    # American cells with a separator of thousands
    "quoted_thousands": rows("Book1.csv", "Time (s),Accel X (mg),Accel Y (mg),Accel Z (mg)",
                             lambda s: f"{s.t:.3f}," + ",".join(map(decimals, map(str, s.a))),
                             MILLI_G, None),
    "narrow_blanks": rows("classeur.csv", "Temps;Acc X;Acc Y;Acc Z;Gyro X;Gyro Y;Gyro Z\n"
                          "ms;mg;mg;mg;mdps;mdps;mdps", french, MILLI_G, 1000 / DEG),
    # numbers through a word processor: U+2212
    "typographic_minus": rows("notes.csv", "t;ax;ay;az;gx;gy;gz",
                              lambda s: ";".join(s.cells).replace("-", "−")),
    # which accountants write for negative ones
    "negative_in_brackets": rows("book.csv", f"t,{AXES}", lambda s: ",".join(
        f"({v[1:]})" if v[0] == "-" else v for v in s.cells)),
    # Excel's `Unicode Text`: UTF-16, tabs, decimal commas
    "unicode_text": rows("Mappe.txt", "Zeit (s)\tax (g)\tay (g)\taz (g)\tgx (°/s)\tgy (°/s)\t"
                         "gz (°/s)", lambda s: comma("\t".join(s.cells)), PER_G, PER_DEG,
                         encoding="utf-16", end="\r\n"),
    # UTF-16 without its mark
    "wide_letters": rows("win.csv", f"t_s,{AXES}", lambda s: s.s, encoding="utf-16-be"),
    # Excel's logger: NaN, nothing and null where a slower sensor had no sample
    "missing_values": rows("merged.csv", f"timestamp,{AXES},temperature,pressure", lambda s: (
        f"{s.s},{'' if s.i % 10 else '25.1'},{'null' if s.i % 25 else '1013.2'}"),
        change=lose_readings),
    "lost_samples": rows("lossy.csv", "Time_s;Ax_g;Ay_g;Az_g;Gx_dps;Gy_dps;Gz_dps",
                         lambda s: ";".join(s.cells), PER_G, PER_DEG, change=lose_samples),
    # what a port holds when it is opened, and a card after power was lost
    "zero_bytes": rows("card.csv", f"\0boot\nt,{AXES}", lambda s: s.s, change=cut_a_line),
    "duplicate_headers": rows("xyz.csv", "Time,X,Y,Z,X,Y,Z", lambda s: s.s, change=begin_again),
    # words in the cells of readings, in the first row already
    "event_lines": rows("events.csv", f"time_s,{AXES}\n0,EVENT,button,,,,", lambda s: s.s,
                        change=event_lines),
    # its cells are empty in three of four rows
    "slow_gyroscope": rows("mixed.csv", f"t,{AXES}", lambda s: (
        s.s if s.i % 4 == 1 else f"{s.t:.3f},{s.a:,.6f},,,")),
    # a row for each of the sensors, the cells of the other are empty
    "taking_turns": rows("turns.csv", f"t,{AXES}", lambda s: (
        f"{s.t:.3f},{s.a:,.6f},,,\n{s.t + 0.002:.4f},,,,{s.w:,.6f}")),
    # Science Journal: a row for each axis, whose cells of the others are empty
    "axes_in_rows_of_their_own": rows(
        "recording.csv", "relative_time,AccX,AccY,AccZ", lambda s: "\n".join(
            f"{round(1000 * s.t) + k},{',' * k}{v:.6f}{',' * (2 - k)}" for k, v in enumerate(s.a)),
        gyr=None),
    # sixty columns of a data logger, the sensor among them
    "wide": rows(
        "daq.csv", ",".join(["time", *(f"ch{i}" for i in range(25)), *(
            f"imu_{name}_{axis}" for name in ("accel", "gyro") for axis in "xyz"), *(
            f"state_{i}" for i in range(28))]), lambda s: (
            f"{s.t:.3f},{state(s, range(25))},{s.a:,.6f},{s.w:,.6f},"
            + ",".join(f"{(s.i + j) % 5}" for j in range(28))), gyr=PER_DEG),
    # two units in one file; the first is taken, and that is said
    "two_sensors": rows(
        "both_imus.csv", "time_ms,acc1_x,acc1_y,acc1_z,gyr1_x,gyr1_y,gyr1_z,acc2_x,acc2_y,acc2_z,"
        "gyr2_x,gyr2_y,gyr2_z", lambda s: f"{1000 * s.t:.0f}" + 2 * f",{s.a:,.6f},{s.w:,.6f}"),
    # a board whose gyroscope is mounted a quarter turn from its accelerometer
    "two_chips": rows("gy85.csv", "ms,adxl_ax,adxl_ay,adxl_az,itg_gx,itg_gy,itg_gz", lambda s: (
        f"{1000 * s.t:.5f},{s.a:,.5f},{-s.w[1]:.5f},{s.w[0]:.5f},{s.w[2]:.5f}")),
    "both_sensors_in_the_file": rows(  # though its name ends in one
        "Acc and Gyro.csv", "t (s),acc x (m/s^2),acc y (m/s^2),acc z (m/s^2),gyr x (rad/s),"
        "gyr y (rad/s),gyr z (rad/s)", lambda s: s.s),
    # a node for each of two boards
    "two_boards": rows("nodes.csv", f"t,{AXES},node", lambda s: (
        f"{s.s},A4:CF:12\n{s.t:.3f},{s.a[1]:.6f},{s.a[2]:.6f},{s.a[0]:.6f},{s.w:,.6f},B0:B2:1C")),
    # EMG at three times the rate in the same table, whose header repeats the name of its clock
    "a_clock_beside_every_channel": rows("Run.csv", ",".join(f"X[s],{name}" for name in (
        "EMG 4[V]", *(f"{name}.{axis} 4 (IM)[{unit}]" for name, unit in (
            ("ACC", "g"), ("GYRO", "deg/s")) for axis in "XYZ"))), lambda s: (
        f"{s.i / 150:.5f},{1e-5 * np.sin(s.i):.3e}" + "".join(
            f",{s.i / 50:.4f},{v:.6f}" for v in (*s.a, *s.w))), PER_G, PER_DEG),
    # ustime, and a quaternion beside the readings
    "microseconds_in_front": rows("teensy.csv", f"ustime,qw,qx,qy,qz,{AXES}", lambda s: (
        f"{s.t * 1e6:.0f},{attitude(s):,.5f},{s.a:,.5f},{s.w:,.5f}")),
}
