"""One recording in several files: a pose that was cut, files that go on or overlap, cut rows."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.pipeline.guess.evening import Evening
from tests.pipeline.guess.foreign import samples, write_lines
from tests.pipeline.guess.hand_log import hand_log
from tests.sessions import pipeline, run_without_page

HEAD = "time_s,ax_m_s2,ay_m_s2,az_m_s2,gx_rad_s,gy_rad_s,gz_rad_s"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def rows() -> list[str]:
    """A log of 18 rests with turns between them, as lines."""
    return [each.s for each in samples(hand_log(rate_hz=50.0))]


@pytest.mark.parametrize(("cuts", "says"), [
    ([(0, 1350), (1350, 2700)], "b.csv goes on where a.csv ends"),
    ([(0, 1380), (1380, 2700)], "b.csv goes on where a.csv ends"),  # in a rest
    ([(0, 1450), (1250, 2700)], "the first 200 rows of b.csv are the last ones of a.csv"),
    ([(1250, 2700), (0, 1450)], "the first 200 rows of a.csv are the last ones of b.csv"),
    ([(0, 900), (850, 1800), (1700, 2700)], "the first 100 rows of c.csv")])
def test_files_that_go_on_or_overlap_are_one_log(
    here: Path, capsys: pytest.CaptureFixture[str], rows: list[str],
    cuts: list[tuple[int, int]], says: str,
) -> None:
    files = [write_lines(here / f"{name}.csv", [HEAD, *rows[begin:end]]).name
             for name, (begin, end) in zip("abc", cuts, strict=False)]
    assert pipeline("import", *files, "--output", "c.yaml") == 0
    assert says in capsys.readouterr().err
    accelerometer = run_without_page(here / "c.yaml")["accelerometer"]
    assert accelerometer["n_poses"] == 18
    assert {pose["label"].rpartition(" ")[0] for pose in accelerometer["poses"]} != {"a.csv"}


@pytest.mark.parametrize(("cuts", "twice", "header"), [
    ([(0, 1450), (1250, 2700)], 200, False),  # parts that overlap
    ([(0, 2700), (0, 2700)], 2700, True),  # the file twice
    ([(0, 1450), (1250, 1400), (1450, 2700)], 150, False),  # a block that was copied
    ([(0, 2700), (2500, 2600)], 100, True),  # another at the end
])
def test_rows_that_a_file_holds_twice_count_once(
    here: Path, capsys: pytest.CaptureFixture[str], rows: list[str],
    cuts: list[tuple[int, int]], twice: int, header: bool,
) -> None:
    lines = [line for i, (begin, end) in enumerate(cuts)
             for line in ([HEAD] if header or i == 0 else []) + rows[begin:end]]
    write_lines(here / "a.csv", lines)
    assert pipeline("import", "a.csv") == 0
    assert (f"rows that repeat those before and are left out: {twice} of {2700 + twice}"
            in capsys.readouterr().err)
    assert run_without_page(here / "a.yaml")["accelerometer"]["n_poses"] == 18


@pytest.mark.parametrize("at", [0, 100])
def test_files_whose_common_times_have_other_readings_are_not_joined(
    here: Path, capsys: pytest.CaptureFixture[str], rows: list[str], at: int
) -> None:
    other = rows[1250:]
    cells = other[at].split(",")
    other[at] = ",".join([cells[0], "9.5", *cells[2:]])
    for name, part in (("a", rows[:1450]), ("b", other)):
        write_lines(here / f"{name}.csv", [HEAD, *part])
    assert pipeline("import", "a.csv", "b.csv") == 4
    assert "digit by digit" in capsys.readouterr().err


@pytest.mark.parametrize(("begin", "cut", "header"), [
    (200, 2, True), (200, 2, False), (500, 1, False), (500, 1, True)])
def test_a_first_row_that_begins_in_the_middle_of_its_time_is_left_out(
    here: Path, capsys: pytest.CaptureFixture[str], rows: list[str], begin: int, cut: int,
    header: bool,
) -> None:
    """The rest of the number is a time before the log, within its length."""
    part = [rows[begin][cut:], *rows[begin + 1 :]]
    write_lines(here / "a.csv", [HEAD, *part] if header else part)
    assert pipeline("import", "a.csv", "--gyroscope-unit", "rad_s") == 0
    said = capsys.readouterr()
    assert f"left out: 1 of {2700 - begin}" in said.err
    assert "pauses" not in said.out


@pytest.mark.parametrize("parts", [2, 3, 4])
def test_a_pose_that_is_cut_into_files_counts_once(
    here: Path, capsys: pytest.CaptureFixture[str], parts: int
) -> None:
    files = [str(path.relative_to(here)) for path in
             Evening(rate_hz=100.0).write(here, "rest", 0.0, 1)]
    head, *rows = Path(files[3]).read_text("utf-8").splitlines()
    cuts = [0, 500, 650, len(rows)] if parts > 2 else [0, 300, len(rows)]
    shared = 40 * (parts == 4)  # the last rows of the file before
    for i, (begin, end) in enumerate(pairwise(cuts)):
        begin = max(begin - shared, 0)
        Path(f"rest/p04_{i}.csv").write_text("\n".join([head, *rows[begin:end]]), "utf-8")
        files.append(f"rest/p04_{i}.csv")
    Path(files[3]).unlink()
    assert pipeline("import", *sorted(set(files) - {files[3]})) == 0
    assert "one pose that was cut; it counts once, by its longest part" in capsys.readouterr().out
    assert run_without_page(here / "config.yaml")["accelerometer"]["n_poses"] == 18


def test_a_copy_of_a_pose_is_left_out_with_a_word(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = Evening().write(here, "rest", 0.0, 1)
    copy = here / "rest" / "p05 - Copy.csv"
    copy.write_bytes(files[4].read_bytes())
    names = [str(path.relative_to(here)) for path in sorted([*files, copy])]
    assert pipeline("import", *names) == 0
    assert "left out, because it holds the numbers of rest/p05" in capsys.readouterr().out
    assert run_without_page(here / "config.yaml")["accelerometer"]["n_poses"] == 18


def test_rows_whose_newest_is_first_are_read_from_the_end(
    here: Path, capsys: pytest.CaptureFixture[str], rows: list[str]
) -> None:
    write_lines(here / "a.csv", [HEAD, *rows[::-1]])
    assert pipeline("import", "a.csv") == 0
    said = capsys.readouterr()
    assert "its newest row is first" in said.err
    assert "mounted differently" not in said.out
    assert run_without_page(here / "a.yaml")["accelerometer"]["n_poses"] == 18


def test_a_port_that_begins_with_the_mark_of_utf_16_is_read(here: Path, rows: list[str]) -> None:
    text = "\n".join([HEAD, *rows]).encode()
    (here / "a.log").write_bytes(b"\xff\xfe\x00\x80\xe07,0.3\n" + text)
    assert pipeline("import", "a.log") == 0


def test_means_at_two_rates_of_the_plate_are_to_be_parted_and_then_read(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    evening, head = Evening(seconds=2.0), "ax (g),ay (g),az (g),gx (deg/s),gy (deg/s),gz (deg/s)"
    tables = {name: [np.loadtxt(path, delimiter=",", skiprows=1, usecols=(1, 2, 3, 5, 6, 7)).mean(
        axis=0) / np.repeat([8192, 65.536], 3) for path in evening.write(here, name, rpm, 1)]
        for name, rpm in (("rest", 0.0), ("turning", evening.rpm))}
    for name, means in (*tables.items(), ("both", [*tables["rest"], *tables["turning"]])):
        np.savetxt(here / f"{name}.csv", means, "%.5f", ",", header=head, comments="")
    assert pipeline("import", "both.csv", "--output", "c.yaml") == 4
    assert "18 of its rows are at rest and 18 of its rows turn at 33" in capsys.readouterr().err
    assert pipeline("import", "rest.csv", "turning.csv", "--output", "c.yaml") == 0
    assert "gyroscope       36 poses in 2 runs" in capsys.readouterr().out


def test_means_of_counts_are_counts_though_they_are_no_whole_numbers(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    evening = Evening(seconds=2.0)
    for name, rpm in (("rest", 0.0), ("33rpm", evening.rpm)):
        means = [np.loadtxt(path, delimiter=",", skiprows=1, usecols=(1, 2, 3, 5, 6, 7)).mean(
            axis=0) for path in evening.write(here, name, rpm, 1)]
        np.savetxt(here / f"{name}.csv", means, "%.2f", ",", header="ax,ay,az,gx,gy,gz",
                   comments="")
    assert pipeline("import", "rest.csv", "33rpm.csv", "--output", "c.yaml") == 0
    printed = capsys.readouterr().out
    assert "counts, 65.536 per °/s" in printed
    assert "gyroscope       36 poses in 2 runs" in printed
