"""The vision stage: clips are followed once, and several of them make the rate of one setting."""

import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
import pytest

import vision.tracking.track
from pipeline.config.schema import PlateSection
from pipeline.console.rate_text import clip_lines
from pipeline.report.plate.rate_charts import rate_view
from pipeline.results.rate import rate_section
from pipeline.stages.context import RunContext
from pipeline.stages.plate_settings import rim
from pipeline.stages.rate import ClipToFollow, follow_clips, measure_setting
from pipeline.stages.track_cache import kept_track, track_key
from tests.paths import ROOT
from vision.errors import RateRefused, UnreadableVideo
from vision.geometry import PlateOverride
from vision.phase_track import PhaseTrack
from vision.rate.timebase import Timebase

CLIP = ROOT / "data/example/video/17rpm.mp4"


@dataclass(frozen=True, eq=False)
class Followed:
    """A clip that was followed into a cache, and the names of all that were followed since."""

    cache: Path
    track: PhaseTrack
    names: list[str]


@pytest.fixture(scope="module")
def followed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Followed]:
    names: list[str] = []
    real = vision.tracking.track.track_phase

    def counting(path: Path, **settings: object) -> PhaseTrack:
        names.append(path.name)
        return real(path, **settings)  # type: ignore[arg-type]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(vision.tracking.track, "track_phase", counting)
        cache = tmp_path_factory.mktemp("cache")
        (track,) = follow_clips([ClipToFollow(CLIP)], RunContext(cache))
        yield Followed(cache, track, names)


def test_a_clip_that_did_not_change_is_not_followed_again(followed: Followed) -> None:
    before = len(followed.names)
    (again,) = follow_clips([ClipToFollow(CLIP)], RunContext(followed.cache))
    assert len(followed.names) == before
    for one, other in ((followed.track, again), (followed.track.plate, again.plate)):
        for name in {field.name for field in fields(one)} - {"plate"}:
            assert type(getattr(one, name)) is type(getattr(other, name)), name
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_a_damaged_track_in_the_cache_is_followed_anew(followed: Followed) -> None:
    (kept,) = followed.cache.iterdir()
    whole = kept.read_bytes()
    kept.write_bytes(whole[: len(whole) // 2])
    before = len(followed.names)
    follow_clips([ClipToFollow(CLIP)], RunContext(followed.cache))
    assert len(followed.names) == before + 1
    assert kept.read_bytes() == whole


def test_another_ellipse_or_other_bytes_are_another_track(tmp_path: Path) -> None:
    clip = tmp_path / "clip.mp4"
    clip.write_bytes(b"one")
    key = track_key(clip, None)
    assert key == track_key(clip, None)
    assert key != track_key(clip, PlateOverride((1.0, 2.0), 3.0))
    assert key != track_key(clip, None, 2.5)
    clip.write_bytes(b"two")
    assert key != track_key(clip, None)


def test_a_track_is_kept_where_there_is_a_cache_and_only_there(
    followed: Followed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(vision.tracking.track, "track_phase", lambda *_, **__: followed.track)
    monkeypatch.chdir(tmp_path)
    assert follow_clips([ClipToFollow(CLIP)], RunContext(None)) == [followed.track]
    assert not list(tmp_path.iterdir())
    assert kept_track(tmp_path, "key", lambda: followed.track) is followed.track
    assert [path.name for path in tmp_path.iterdir()] == ["key.npz"]


def test_clips_share_their_clock_and_nothing_else(followed: Followed) -> None:
    one = measure_setting("slow", [followed.track], Timebase(ppm=20.0))
    many = measure_setting("slow", [followed.track] * 18, Timebase(ppm=20.0))
    assert many.plate.rate_rad_s.shape == (18,)
    assert many.rate_rad_s == pytest.approx(one.rate_rad_s)
    assert many.image_sd_rad_s == pytest.approx(one.image_sd_rad_s / np.sqrt(18))
    for rate in (one, many):  # the mean of eighteen equal numbers may differ in its last digit
        assert rate.timebase_sd_rad_s == pytest.approx(20e-6 * one.rate_rad_s)


def test_all_rates_that_give_the_same_frames_are_printed(followed: Followed) -> None:
    rate = measure_setting("slow", [followed.track], Timebase())
    (line,) = (line for line in clip_lines(rate) if "give the same frames" in line)
    printed = [(float(rpm), way) for rpm, way in re.findall(r"([\d.]+) (ccw|cw)", line)]
    # 15 frames per second: 900 rpm apart, three to either side of 16.667.
    assert printed == [(883.3, "cw"), (916.7, "ccw"), (1783, "cw"), (1817, "ccw"), (2683, "cw"),
                       (2717, "ccw")]


def test_a_clip_tracked_by_colour_names_the_colour_axis(followed: Followed) -> None:
    plain = measure_setting("slow", [followed.track], Timebase())
    assert rate_section(plain).clips[0].channel == "luma"
    assert not any("colour" in line for line in clip_lines(plain))
    plate = replace(followed.track.plate, channel="0.98 Cr - 0.20 Cb")
    coloured = replace(followed.track, plate=plate)
    rate = measure_setting("slow", [coloured], Timebase())
    assert rate_section(rate).clips[0].channel == "0.98 Cr - 0.20 Cb"
    assert any("tracked by colour, 0.98 Cr - 0.20 Cb" in line for line in clip_lines(rate))
    assert ("tracked by colour", "0.98 Cr - 0.20 Cb") in rate_view(rate).facts


def test_clips_that_turn_both_ways_are_no_one_setting(followed: Followed) -> None:
    back = replace(followed.track, phase_rad=-followed.track.phase_rad, source="back.mp4")
    with pytest.raises(RateRefused, match=r"17rpm\.mp4 turns ccw and back\.mp4 turns cw"):
        measure_setting("slow", [followed.track, back], Timebase())


def test_the_clip_reported_is_the_first_that_fails(tmp_path: Path) -> None:
    for name in ("first.mp4", "second.mp4"):
        (tmp_path / name).write_bytes(b"no film")
    clips = [ClipToFollow(tmp_path / "first.mp4"), ClipToFollow(tmp_path / "second.mp4")]
    with pytest.raises(UnreadableVideo, match=r"first\.mp4"):
        follow_clips(clips, RunContext(tmp_path / "cache"))
    assert not (tmp_path / "cache").exists()


def test_ctrl_c_while_the_plate_is_being_learned_ends_at_once() -> None:
    code = """if True:
        import sys, time, pipeline.cli, vision.plate.learn
        def learn(name, frames, channel, rim, on_step):
            print("learning", flush=True)
            while True:
                on_step()
                time.sleep(0.01)
        vision.plate.learn.learn = learn
        sys.exit(pipeline.cli.main(["rate", *sys.argv[1:]]))
    """
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(CLIP)], cwd=ROOT, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "learning\n"
    process.send_signal(signal.SIGINT)
    said, complained = process.communicate(timeout=240)
    assert (process.returncode, said) == (130, "")
    assert complained.strip().startswith("Interrupted")
    assert "Traceback" not in complained


@pytest.mark.parametrize("radii", [(300.0, 200.0), (200.0, 300.0)])
def test_the_longer_radius_of_a_stated_ellipse_leads_whichever_is_given_first(
    radii: tuple[float, float],
) -> None:
    given = rim(PlateSection(centre_px=(1.0, 2.0), radii_px=radii, angle_deg=10.0))
    assert (given.radius_px, given.minor_px) == (300.0, 200.0)
    assert given.angle_deg == (10.0 if radii[0] > radii[1] else 100.0)


def test_a_stated_ellipse_reaches_the_film(
    monkeypatch: pytest.MonkeyPatch, followed: Followed
) -> None:
    given: list[PlateOverride] = []

    def taking(_path: Path, *, plate: PlateOverride, **_further: object) -> PhaseTrack:
        given.append(plate)
        return followed.track

    monkeypatch.setattr(vision.tracking.track, "track_phase", taking)
    stated = PlateOverride((1.0, 2.0), 3.0)
    follow_clips([ClipToFollow(CLIP, stated)], RunContext())
    assert given == [stated]
