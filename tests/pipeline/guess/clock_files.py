"""Tables with odd clocks: dates, counters, clocks that step, wrap, end or begin again."""

from pathlib import Path

import numpy as np

from tests.pipeline.guess.foreign import (
    AXES,
    DEG,
    EPOCH_S,
    Foreign,
    G,
    Sample,
    Values,
    Writer,
    comma,
    rows,
    samples,
    when,
    write_lines,
)
from tests.pipeline.guess.hand_log import HandLog

PER_COUNT = {"acc": 16384 / G, "gyr": 131.072 / DEG}
IN_G = {"acc": 1 / G, "gyr": 1 / DEG}
TICKS = 2**32  #: of a counter, which then begins again


def readings(sample: Sample) -> str:
    """The cells behind the clock."""
    return f"{sample.a:,.6f},{sample.w:,.6f}"


def time_resets(folder: Path, log: HandLog) -> Foreign:
    """The board was reset in the middle: millis begins again."""
    half = len(log.time_s) // 2
    return rows("reset.csv", f"millis,{AXES}", lambda s: (
        f"{1000 * (s.t - (log.time_s[half] if s.i >= half else 0)):.0f},{s.c:,d}"),
        **PER_COUNT)(folder, log)


def clock_set_back(folder: Path, log: HandLog) -> Foreign:
    """One step of 0.9 s back in the middle."""
    half = len(log.time_s) // 2
    return rows("nexus.csv", f"timestamp,{AXES}", lambda s: (
        f"{EPOCH_S + s.t - 0.9 * (s.i >= half):.4f},{readings(s)}"))(folder, log)


def properties_above(folder: Path, log: HandLog) -> Foreign:
    """LabVIEW's TDMS as a table: what holds for each channel stands above it, with its name in a
    column of its own; numbers among it are no readings."""
    above = {"wf_start_time": "03/11/2024 10:11:12 AM", "wf_increment": 1 / log.rate_hz,
             "wf_samples": len(log.time_s)}
    head = ["Group" + 6 * ",IMU", "Channel," + ",".join(
        f"{name} {axis}" for name in ("Acc", "Gyro") for axis in "XYZ"),
        "unit_string,g,g,g,deg/s,deg/s,deg/s",
        *(f"{name}" + 6 * f",{value}" for name, value in above.items())]
    return rows("tdms.csv", "\n".join(head), lambda s: f",{readings(s)}", **IN_G)(folder, log)


def intervals(folder: Path, log: HandLog) -> Foreign:
    """Microseconds since the sample before."""
    steps = 1e6 / log.rate_hz + np.random.default_rng(1).integers(-40, 40, len(log.time_s))
    return rows("teensy.csv", f"dt_us,{AXES}", lambda s: f"{steps[s.i]:.0f},{readings(s)}",
                **IN_G)(folder, log)


def runs_beside(folder: Path, log: HandLog) -> Foreign:
    """Two recordings side by side; each counts from 0."""
    names = ("Time (s)", "Acc X (m/s²)", "Acc Y (m/s²)", "Acc Z (m/s²)",
             "Gyro X (rad/s)", "Gyro Y (rad/s)", "Gyro Z (rad/s)")
    head = ",".join(f"Run {run}: {name}" for run in (1, 2) for name in names)
    half = int(np.argmax(log.rest == 9))
    every = samples(log)
    return Foreign([write_lines(folder / "runs.csv", [head, *(
        f"{one.s},{one.t:.3f},{readings(other)}"
        for one, other in zip(every[:half], every[half:], strict=True))])])


def row_number_and_interval(folder: Path, log: HandLog) -> Foreign:
    """The rows are counted, and each states the time since the one before."""
    return rows("print.txt", "", lambda s: (
        f"{s.i} acc=[" + " ".join(f"{v: .5f}" for v in s.a) + "] gyro=["
        + " ".join(f"{v: .6f}" for v in s.w) + f"] dt={1 / log.rate_hz:.4f}"))(folder, log)


def labview_measurement(folder: Path, log: HandLog) -> Foreign:
    """LVM: settings in rows of numbers above the header, a column of comments that rows leave out.
    """
    settings = [f"{name}" + 6 * f"\t{cell}" + "\t" for name, cell in (
        ("Samples", "100"), ("Date", "2024/05/01"), ("X0", "0,00E+0"), ("Delta_X", "0,010000"))]
    head = ["LabVIEW Measurement\t", "Decimal_Separator\t,", "***End_of_Header***\t", "\t",
            *settings, "***End_of_Header***" + 7 * "\t",
            "X_Value\tAccel_X\tAccel_Y\tAccel_Z\tGyro_X\tGyro_Y\tGyro_Z\tComment"]
    return rows("m.lvm", "\n".join(head), lambda s: comma("\t".join(s.cells)), **IN_G,
                end="\r\n")(folder, log)


CLOCKS: dict[str, Writer] = {
    "time_resets": time_resets, "clock_set_back": clock_set_back, "intervals": intervals,
    "properties_above": properties_above, "runs_beside": runs_beside,
    "row_number_and_interval": row_number_and_interval,
    "labview_measurement": labview_measurement,
    "euroc": rows("data.csv", "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],"
                  "w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]",
                  lambda s: f"{1_403_636_579 * 10**9 + round(s.t * 1e9)},{s.w:,.8g},{s.a:,.8g}"),
    "german_excel": rows(
        "messung.csv", "time;AccX (g);AccY (g);AccZ (g);GyrX (°/s);GyrY (°/s);GyrZ (°/s)",
        lambda s: f"{when(s.t, '%d.%m.%Y %H:%M:%S,%f')};" + comma(f"{s.a:;.6f};{s.w:;.6f}"),
        **IN_G, encoding="cp1252"),
    "sensor_log_ios": rows(
        "phone.csv", "loggingTime(txt),accelerometerAccelerationX(G),accelerometerAccelerationY(G),"
        "accelerometerAccelerationZ(G),motionUserAccelerationX(G),motionUserAccelerationY(G),"
        "motionUserAccelerationZ(G),gyroRotationX(rad/s),gyroRotationY(rad/s),"
        "gyroRotationZ(rad/s),gyroTimestamp_sinceReboot(s)", lambda s: (
            f"{when(s.t, '%Y-%m-%dT%H:%M:%S.%f')}+00:00,{Values(-v for v in s.a):,.7g},0.01,0.02,"
            f"0.01,{s.w:,.7g},{5000 + s.t:.4f}"), acc=1 / G),
    # `12:00:00.010 -> ` before every line, as the serial monitor puts it
    "arduino_ide_stamps": rows("monitor.txt", "", lambda s: (
        f"{when(s.t, '%H:%M:%S.%f')} -> {s.c:,d}"), **PER_COUNT),
    # SparkFun's OpenLog Artemis: dates of two columns, mg, deg/s, a trailing comma
    "open_log_artemis": rows(
        "dataLog00012.TXT", "rtcDate,rtcTime,aX,aY,aZ,gX,gY,gZ,mX,mY,mZ,imu_degC,output_Hz,",
        lambda s: f"{when(s.t, '%m/%d/%Y,%H:%M:%S.%f')[:-1]},{s.a:,.2f},{s.w:,.2f},12.3,-4.5,6.7,"
                  "27.1,100.000,", 1e3 / G, 1 / DEG),
    "dates_with_ms": rows("wt901.csv", "Timestamp,Accel X (g),Accel Y (g),Accel Z (g),"
                          "Gyro X (deg/s),Gyro Y (deg/s),Gyro Z (deg/s)", lambda s: (
                              f"{when(s.t, '%Y-%m-%d %H:%M:%S.%f')},{readings(s)}"), **IN_G),
    # WitMotion: tabs, blanks in the names, the time of day, angles beside
    "witmotion": rows(
        "20240311.txt", "StartTime: 2024-03-11 10:11:12.013\naddress\tTime(s)\tChipTime\tax(g)\t"
        "ay(g)\taz(g)\twx(deg/s)\twy(deg/s)\twz(deg/s)\tAngleX(deg)\tAngleY(deg)\tAngleZ(deg)\t"
        "T(°)\thx\thy\thz", lambda s: (
            f"0x50\t{when(s.t, '%H:%M:%S.%f')}\t2024-3-11 10:11:12\t{s.a:\t.4f}\t{s.w:\t.4f}\t1.0\t"
            "2.0\t3.0\t31.2\t100\t200\t300"), **IN_G),
    # dates with the month's name
    "matlab_mobile": rows("Acceleration.csv", "Timestamp,X,Y,Z", lambda s: (
        f"{when(s.t, '%d-%b-%Y %H:%M:%S.%f')},{s.a:,.5f}"), gyr=None),
    # ST's application: a date with slashes, its own clock, and before readings the board's clock
    # in ticks of 8 ms and the bytes as they came
    "clocks_of_two_devices": rows(
        "board.csv", "Date,HostTimestamp,NodeName,NodeTimestamp,RawData,ax (m/s²),ay (m/s²),"
        "az (m/s²),gx (dps),gy (dps),gz (dps)", lambda s: (
            f"{when(s.t, '%d/%b/%Y %H:%M:%S.%f')},{EPOCH_S * 1000 + round(s.t * 1e3)},board,"
            f"{1200 + round(s.t * 125)},{int(abs(s.a[0]) * 7e4):08X},{s.a:,.4f},{s.w:,.4f}"),
        gyr=1 / DEG),
    # a stopwatch: minutes, seconds and a fraction
    "minutes": rows("watch.csv", "Elapsed,aX,aY,aZ,gX,gY,gZ", lambda s: (
        f"{int(s.t // 60):02d}:{s.t % 60:06.3f},{readings(s)}"), **IN_G),
    # a dashboard shows the last sample first
    "newest_first": rows("grafana.csv", f"Time,{AXES}", lambda s: (
        f"{when(s.t, '%Y-%m-%d %H:%M:%S.%f')},{readings(s)}"), change=list.reverse),
    # fields by number
    "thingspeak": rows(
        "feeds.csv", "created_at,entry_id,field1,field2,field3,field4,field5,field6", lambda s: (
            f"{when(s.t, '%Y-%m-%dT%H:%M:%S.%f')}+00:00,{s.i + 1},{readings(s)}"), gyr=1 / DEG),
    # SampleTimeFine in microseconds, where an MTi's ticks at 10 kHz, and it wraps
    "movella_dot": rows(
        "Xsens DOT 3_D422CD00.csv", "sep=,\nDeviceTag:,Xsens DOT 3\nOutputRate:,100Hz\n\n"
        "PacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,", lambda s: (
            f"{s.i + 1},{(round(s.t * 1e6) + TICKS - 50_000_000) % TICKS},{readings(s)},"),
        gyr=1 / DEG),
    # days since 1900, as a spreadsheet stores a date
    "spreadsheet": rows("sheet.csv", "Date,AccX [g],AccY [g],AccZ [g],GyroX [rad/s],GyroY [rad/s],"
                        "GyroZ [rad/s]", lambda s: (
                            f"{46085.41666667 + s.t / 86400:.10f},{s.a:,.5f},{s.w:,.5f}"), 1 / G),
    # a timetable of MATLAB: `0.02 sec`
    "durations": rows("tt.csv", "Time,Acceleration_1,Acceleration_2,Acceleration_3,"
                      "AngularVelocity_1,AngularVelocity_2,AngularVelocity_3",
                      lambda s: f"{s.t:.3f} sec,{readings(s)}"),
    # a clock that shows the same second in fifty rows
    "whole_seconds": rows("export.csv", "Date/Time,Ax,Ay,Az,Gx,Gy,Gz",
                          lambda s: f"04/03/2026 14:05:{int(s.t):02d},{readings(s)}"),
    # `printf("%d.%d", s, ms)`: 12.20 is followed by 12.40, and 12.980 by 13.0
    "milliseconds_without_zeros": rows("rtc.csv", f"time,{AXES}", lambda s: (
        f"10:11:{int(s.t):02d}.{round(1000 * s.t) % 1000},{readings(s)}"), **IN_G),
    # 101159980, followed by 101200000: hours, minutes, seconds and milliseconds in one number
    "clock_face": rows("face.csv", f"time,{AXES}", lambda s: (
        f"10{11 + int(s.t + 20) // 60}{(s.t + 20) % 60:06.3f}".replace(".", "")
        + f",{readings(s)}"), **IN_G),
    # `f"{stamp.secs}.{stamp.nsecs}"`
    "nanoseconds_without_zeros": rows("ros.csv", f"stamp,{AXES}", lambda s: (
        f"{EPOCH_S + int(s.t)}.{round(1e9 * s.t) % 10**9},{readings(s)}")),
    # `0 days 00:00:01.02`
    "differences_of_pandas": rows("delta.csv", f"t,{AXES}",
                                  lambda s: f"0 days 00:00:{s.t:09.6f},{readings(s)}"),
    # a printed frame: the line of names has none for the numbers of the rows; minutes
    "printed_frame": rows(
        "frame.txt", " " * 6 + "".join(f"{name:>12}" for name in ("min", *AXES.split(","))),
        lambda s: f"{s.i:<6d}{s.t / 60:12.8f}" + "".join(f"{cell:>12}" for cell in s.cells[1:])),
    # milliseconds with a colon behind them, and a bar of text between the sensors
    "time_with_a_colon": rows("teensy.txt", "# raw", lambda s: (
        f"{1000 * s.t:.0f}: {Values(s.c[:3]): d} / {Values(s.c[3:]): d}"), 4096 / G, 16.384 / DEG),
}
