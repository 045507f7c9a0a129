"""Files of other programs that are damaged, hostile or something else."""

import io
import json
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest

from tests.attack.case import Case, check, write

NOISE = np.random.default_rng(5).bytes(3000)
ROWS = "time_s,acc_x,acc_y,acc_z\n" + "0.01,1,2,3\n" * 50
DAMAGED_BEGINNINGS = {
    "bin": b"\xa3\x95\x80", "ulg": b"ULog\x01\x12\x35\x01" + bytes(8), "mcap": b"\x89MCAP0\r\n",
    "bag": b"#ROSBAG V2.0\n", "db3": b"SQLite format 3\0", "parquet": b"PAR1",
    "h5": b"\x89HDF\r\n\x1a\n", "npy": b"\x93NUMPY\x01\x00", "zip": b"PK\x03\x04",
    "mat": b"MATLAB 5.0 MAT-file", "jsonl": b'{"a": ',
}


def npy(array: np.ndarray) -> bytes:
    """A file of NumPy's; objects in it are pickled."""
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def archive(*members: tuple[str, str], password: bool = False) -> bytes:
    """A zip archive; its members count as encrypted where there is a ``password``."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as made, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # two members of one name
        for name, text in members:
            made.writestr(name, text)
    data = file.getvalue()
    at = data.find(b"PK\x01\x02")
    return data[: at + 8] + b"\x01" + data[at + 9 :] if password else data


def refused(name: str, file: str, content: str | bytes, said: str, code: int = 3) -> Case:
    """``import`` of a file that cannot be read."""
    return Case(name, f"import HERE/{file}", code, said, write(file, content))


CASES = (
    *(refused(f"noise that begins as .{ext}", f"m.{ext}", begin + NOISE, "m.")
      for ext, begin in DAMAGED_BEGINNINGS.items()),
    *(refused(f"the beginning of .{ext} alone", f"m.{ext}", begin, "m.")
      for ext, begin in DAMAGED_BEGINNINGS.items()),
    refused("complex numbers", "c.npy", npy(np.ones((500, 7)) * 1j), "holds no readings"),
    refused("pickled objects", "o.npy", npy(np.array([{"a": 1}], dtype=object)), "cannot be read"),
    refused("an array of three dimensions", "d.npy", npy(np.ones((9, 7, 2))), "holds no readings"),
    refused("an array of a million million rows", "b.npy", npy(np.ones((500, 7))).replace(
        b"(500, 7), }  ", b"(10**12, 7),}", 1), "cannot be read"),
    refused("an archive that leads out", "t.zip", archive(("../../evil.csv", ROWS)), "leads out"),
    refused("an archive of absolute names", "a.zip", archive(("/etc/x.csv", ROWS)), "leads out"),
    refused("an archive with a password", "p.zip", archive(("a.csv", ROWS), password=True),
            "protected by a password"),
    refused("an archive with nothing in it", "e.zip", archive(), "this archive holds no readings"),
    refused("JSON nested deeply", "n.json", '{"a":' * 100_000, "an? JSON file but cannot be read"),
    refused("a number of 5000 digits", "h.jsonl", f'{{"time": {"9" * 5000}}}\n' * 20, "cannot"),
    refused("a JSON line cut off", "l.jsonl",
            (json.dumps({"time": 0.0, "acc": [1, 2, 3]}) + "\n") * 20 + '{"time": 1', "l.jsonl:21"),
    Case("a foreign file of noise for apply", "apply RUN HERE/m.bin", 3, "is damaged",
         write("m.bin", b"\xa3\x95\x80" + NOISE)),
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_foreign_files(
    case: Case, copied: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    check(case, copied, capsys)
    assert not list(tmp_path.glob("*.yaml"))
