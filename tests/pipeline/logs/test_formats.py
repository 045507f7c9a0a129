"""Files of other formats, each written by the library of its format, read back as logs."""

import io
import json
import struct
import sys
import zipfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from rosbags.rosbag1 import Writer as Rosbag1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Rosbag2
from rosbags.typesys import Stores, get_typestore
from scipy.io import savemat

from pipeline.errors import UnreadableInput
from pipeline.logs.columns import Renamed
from pipeline.logs.formats import kinds
from pipeline.logs.read import read_log
from tests.pipeline.logs.flight_logs import ardupilot_log, px4_log

N = 50
TIME_S = 100 + 0.01 * np.arange(N)
RNG = np.random.default_rng(0)
ACC = RNG.normal((0, 0, 9.81), 0.1, (N, 3)).astype(np.float32).astype(float)
GYR = RNG.normal(0, 0.01, (N, 3)).astype(np.float32).astype(float)
NAMES = ("time_s", "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z")
COLUMNS = dict(zip(NAMES, np.column_stack([TIME_S, ACC, GYR]).T, strict=True))


def imu_messages(store: object) -> list[tuple[int, object]]:
    types = store.types  # type: ignore[attr-defined]
    vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    header, stamp = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    messages = []
    for i in range(N):
        ns = 100_000_000_000 + 10_000_000 * i
        extra = {"seq": i} if "seq" in header.__dataclass_fields__ else {}
        messages.append((ns, types["sensor_msgs/msg/Imu"](
            header(stamp=stamp(sec=ns // 10**9, nanosec=ns % 10**9), frame_id="imu", **extra),
            quaternion(0.0, 0.0, 0.0, 1.0), np.zeros(9), vector(*GYR[i]), np.zeros(9),
            vector(*ACC[i]), np.zeros(9))))
    return messages


def ros_1(folder: Path) -> Path:
    path, store = folder / "drive.bag", get_typestore(Stores.ROS1_NOETIC)
    with Rosbag1(path) as bag:
        topic = bag.add_connection("/imu/data", "sensor_msgs/msg/Imu", typestore=store)
        for ns, message in imu_messages(store):
            bag.write(topic, ns, store.serialize_ros1(message, "sensor_msgs/msg/Imu"))
    return path


def ros_2(folder: Path, storage: StoragePlugin) -> Path:
    path, store = folder / "drive", get_typestore(Stores.ROS2_HUMBLE)
    with Rosbag2(path, version=8, storage_plugin=storage) as bag:
        topic = bag.add_connection("/imu/data", "sensor_msgs/msg/Imu", typestore=store)
        for ns, message in imu_messages(store):
            bag.write(topic, ns, store.serialize_cdr(message, "sensor_msgs/msg/Imu"))
    return path


def parquet(folder: Path) -> Path:
    path = folder / "log.parquet"
    pq.write_table(pa.table(COLUMNS), path)
    return path


def matlab(folder: Path) -> Path:
    savemat(folder / "log.mat", {name: values[:, None] for name, values in COLUMNS.items()})
    return folder / "log.mat"


def hdf5(folder: Path) -> Path:
    with h5py.File(folder / "log.h5", "w") as file:
        for name, values in COLUMNS.items():
            file[name] = values
    return folder / "log.h5"


def npz(folder: Path) -> Path:
    np.savez(folder / "log.npz", **COLUMNS)
    return folder / "log.npz"


def json_lines(folder: Path) -> Path:
    path = folder / "log.jsonl"
    path.write_text("".join(json.dumps({name: values[i] for name, values in COLUMNS.items()}) + "\n"
                            for i in range(N)))
    return path


def phone(folder: Path) -> Path:
    """Two tables with clocks of their own, in our names so that none has to be picked."""
    with zipfile.ZipFile(folder / "phone.zip", "w") as archive:
        for file, names in (("Accelerometer.csv", NAMES[:4]),
                            ("Gyroscope.csv", (NAMES[0], *NAMES[4:]))):
            text = io.StringIO()
            np.savetxt(text, np.column_stack([COLUMNS[name] for name in names]), delimiter=",",
                       header=",".join(names), comments="")
            archive.writestr(file, text.getvalue())
        archive.writestr("meta/device.csv", "property,value\nname,Pixel\n")
    return folder / "phone.zip"


def px4(folder: Path) -> Path:
    return px4_log(folder / "flight.ulg", TIME_S, ACC, GYR)


def ardupilot(folder: Path) -> Path:
    return ardupilot_log(folder / "flight.bin", TIME_S, ACC, GYR)


WRITERS: dict[str, Callable[[Path], Path]] = {
    "ROS 1": ros_1,
    "ROS 2, SQLite": lambda folder: ros_2(folder, StoragePlugin.SQLITE3),
    "ROS 2, MCAP": lambda folder: ros_2(folder, StoragePlugin.MCAP),
    "one MCAP file": lambda folder: next(ros_2(folder, StoragePlugin.MCAP).glob("*.mcap")),
    "Parquet": parquet, "MATLAB": matlab, "HDF5": hdf5, "npz": npz, "JSON lines": json_lines,
    "archive": phone, "PX4": px4, "ArduPilot": ardupilot,
}


@pytest.mark.parametrize("write", WRITERS.values(), ids=WRITERS)
def test_every_format_gives_the_same_readings(
    tmp_path: Path, write: Callable[[Path], Path]
) -> None:
    log = read_log(write(tmp_path))
    np.testing.assert_allclose(log.time_s, TIME_S, atol=1e-6)
    np.testing.assert_allclose(log.accelerometer, ACC, rtol=1e-6)
    np.testing.assert_allclose(log.gyroscope, GYR, rtol=1e-6)


@pytest.mark.parametrize(("write", "member", "triad"), [
    (ros_1, "imu/data", "accelerometer"), (phone, "Gyroscope.csv", "gyroscope"),
    (px4, "sensor_accel_0", "accelerometer"), (ardupilot, "GYR_0", "gyroscope"),
])
def test_a_table_is_named_like_a_file_in_a_folder(
    tmp_path: Path, write: Callable[[Path], Path], member: str, triad: str
) -> None:
    log = read_log(write(tmp_path) / member)
    assert log.has(triad)
    again = tmp_path / "again"
    again.mkdir()
    with pytest.raises(UnreadableInput, match=r"no table is named 'no_such'.*there are: "):
        read_log(write(again) / "no_such")


def test_columns_of_a_table_are_picked_by_name(tmp_path: Path) -> None:
    pq.write_table(pa.table({"t": TIME_S * 1e3, "east": ACC[:, 0], "north": ACC[:, 1],
                             "up": ACC[:, 2]}), tmp_path / "log.parquet")
    log = read_log(tmp_path / "log.parquet", Renamed(
        (("time_ms", "t"), ("acc_x", "east"), ("acc_y", "north"), ("acc_z", "up"))))
    np.testing.assert_allclose(log.time_s, TIME_S)
    with pytest.raises(UnreadableInput, match=r"found t, east, north, up: .*`pipeline import`"):
        read_log(tmp_path / "log.parquet")


def test_time_stamps_of_parquet_are_seconds(tmp_path: Path) -> None:
    stamps = pa.array((TIME_S * 1e9).astype("datetime64[ns]"))
    table = pa.table({**COLUMNS, "time_s": stamps})
    pq.write_table(table, tmp_path / "log.parquet")
    np.testing.assert_allclose(read_log(tmp_path / "log.parquet").time_s, TIME_S)


# Where pymavlink refuses a file it leaves it open.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("write", WRITERS.values(), ids=WRITERS)
def test_a_file_that_was_cut_off_is_refused_in_one_paragraph(
    tmp_path: Path, write: Callable[[Path], Path]
) -> None:
    path = write(tmp_path)
    path = path if path.is_file() else next(iter([*path.glob("*.mcap"), *path.glob("*.db3")]))
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 3])
    if write in (px4, ardupilot):  # logs of flights end anywhere: what is there is whole
        assert len(read_log(path).time_s) < N
        return
    with pytest.raises(UnreadableInput) as caught:
        read_log(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def npy(folder: Path) -> Path:
    table = np.rec.fromarrays([*COLUMNS.values()], names=",".join(COLUMNS))
    np.save(folder / "log.npy", table)
    return folder / "log.npy"


FLIPPED = 40  #: places of each format
#: Tables whose text is no number, and sizes that no memory has, are refused above the reader.
REFUSED = (UnreadableInput, MemoryError)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("write", [*WRITERS.values(), npy], ids=[*WRITERS, "npy"])
def test_a_flipped_byte_is_refused_or_read_and_never_a_bug(
    tmp_path: Path, write: Callable[[Path], Path]
) -> None:
    whole = write(tmp_path)
    path = whole if whole.is_file() else next(iter([*whole.glob("*.mcap"), *whole.glob("*.db3")]))
    data = path.read_bytes()
    rng = np.random.default_rng(len(data))
    head = rng.integers(0, min(200, len(data)), FLIPPED // 2)  # where a format says what it is
    for at in [*head, *rng.integers(0, len(data), FLIPPED - len(head))]:
        damaged = bytearray(data)
        damaged[at] ^= int(rng.integers(1, 256))
        path.write_bytes(bytes(damaged))
        with suppress(*REFUSED):
            log = read_log(whole)
            assert len(log.time_s) > 0


def test_a_missing_library_names_the_command_that_installs_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = parquet(tmp_path)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.delitem(sys.modules, "pipeline.logs.formats.parquet", raising=False)
    command = r"pip install 'turntable-imu-calibration\[parquet\]'"
    with pytest.raises(UnreadableInput, match=command):
        read_log(path)


@pytest.mark.parametrize(("content", "says"), [
    (b"H Product:Blackbox flight data recorder", "blackbox_decode"),
    (b"\xd0\xcf\x11\xe0" + bytes(20), "Save the sheet as CSV"),
    (b"BZh91AY&SY", "is packed by bzip2. Unpack it"),
    (b"PK\x03\x04" + bytes(40), "archive is damaged"),
    (b"{\"acc_x\": 1}\n{\"acc_x\"", ":2: is no JSON"),
    (struct.pack("<7s", b"ULog\x01\x12\x35") + bytes(9), "PX4 log"),
])
def test_what_cannot_be_read_says_what_to_do(tmp_path: Path, content: bytes, says: str) -> None:
    (tmp_path / "log").write_bytes(content)
    with pytest.raises(UnreadableInput, match=says):
        read_log(tmp_path / "log")


def test_every_kind_has_its_module() -> None:
    folder = Path(kinds.__file__).parent
    for kind in [*kinds.KINDS.values(), kinds.JSON]:
        assert (folder / f"{kind.module}.py").is_file(), kind
