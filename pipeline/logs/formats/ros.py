"""ROS 1 bags, ROS 2 bags (SQLite or MCAP): topics of sensor_msgs/Imu."""

from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.typesys import Stores, get_typestore

from pipeline.errors import UnreadableInput
from pipeline.logs.columns import ACCELEROMETER, GYROSCOPE, TIME
from pipeline.logs.formats.file_table import FileTable

IMU = "sensor_msgs/msg/Imu"
NANOSECOND = 1e-9  #: s


def tables(path: Path) -> list[FileTable]:
    """A table for each topic, in m/s², rad/s and seconds by the header's stamp."""
    try:
        return _tables(path)
    except AnyReaderError as error:
        raise UnreadableInput(f"{path}: is no complete bag ({error}). `rosbag reindex` or `ros2 "
                              "bag reindex` repairs a bag that was cut off.") from error


def _tables(path: Path) -> list[FileTable]:
    rows: dict[str, list[tuple[float, ...]]] = {}
    # Bags of ROS 2 before Iron have no definitions; that of Imu has not changed since then.
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_FOXY)) as bag:
        topics = [connection for connection in bag.connections if connection.msgtype == IMU]
        if not topics:
            listed = ", ".join(f"{other.topic} ({other.msgtype})" for other in bag.connections[:8])
            raise UnreadableInput(f"{path}: no topic of type {IMU}; there are: {listed or 'none'}.")
        for connection, _, raw in bag.messages(connections=topics):
            message: Any = bag.deserialize(raw, connection.msgtype)
            stamp, force, rate = (message.header.stamp, message.linear_acceleration,
                                  message.angular_velocity)
            rows.setdefault(connection.topic, []).append((
                stamp.sec + stamp.nanosec * NANOSECOND,
                force.x, force.y, force.z, rate.x, rate.y, rate.z))
    names = (TIME, *ACCELEROMETER, *GYROSCOPE)
    return [FileTable(topic.strip("/"), dict(zip(names, np.array(samples).T, strict=True)))
            for topic, samples in rows.items()]
