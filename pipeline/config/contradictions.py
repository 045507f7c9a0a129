"""Contradictions between keys of a configuration: gravity, rates, files of two runs, counts."""

import math
from collections.abc import Iterator
from pathlib import Path

from calib.earth import gravity_bounds
from calib.fit.triad.determined import LARGEST_SHARE
from pipeline.config.schema import KnownRateSection, LogsSection, VideoRateSection
from pipeline.config.session import Config
from pipeline.config.yaml_text import Key, PathTo, path_text
from pipeline.text.formatting import count

Problems = Iterator[tuple[PathTo, str]]


def contradictions(config: Config) -> Problems:
    """Places and descriptions of contradictions between valid values."""
    yield from _clip_counts(config)
    yield from _column_counts(config)
    yield from _gravity(config)
    yield from _rates(config)
    yield from _files_of_two_runs(config)
    yield from _headings(config)


def _clip_counts(config: Config) -> Problems:
    """Runs whose numbers of poses and clips differ."""
    for path, run in config.placed_runs():
        rate = config.rate.get(run.rate)
        clips = len(rate.video) if isinstance(rate, VideoRateSection) else 1
        if run.poses.files and clips not in (1, len(run.poses.files)):
            yield (*path, "rate"), (
                f"'{run.rate}' has {clips} clips for {len(run.poses.files)} poses. Give one clip "
                f"for the whole run, or one per pose in the order of the poses."
            )


def _column_counts(config: Config) -> Problems:
    """Lists of column names that do not match the files of a key."""
    sections: list[tuple[PathTo, LogsSection]] = [
        ((*path, "poses"), run.poses) for path, run in config.placed_runs()]
    if config.installation:
        sections.append((("installation",), config.installation))
    for path, section in sections:
        lists = len(section.columns or ())
        for key, paths in section.files_by_key().items():
            if lists > 1 and paths and len(paths) != lists:
                yield (*path, "columns"), (
                    f"{lists} lists of names for the {count(len(paths), 'file')} of `{key}`. Give "
                    f"one list for all files, or one per file in the same order."
                )


def _gravity(config: Config) -> Problems:
    site = config.site
    if site is None or site.gravity_m_s2 is None or site.latitude_deg is None:
        return
    low, high = gravity_bounds(math.radians(site.latitude_deg), site.height_m)
    sd = 3 * (site.sd_m_s2 or 0.0)
    if not low - sd <= site.gravity_m_s2 <= high + sd:
        stated = "height_m" in site.model_fields_set
        yield ("site", "gravity_m_s2"), (
            f"{site.gravity_m_s2:g} m/s² is not gravity at {site.latitude_deg:g}° latitude and "
            f"{site.height_m:g} m height: there it lies between {low:.4f} and {high:.4f}, and the "
            f"scale of the accelerometer would be wrong by the same share. "
            f"{'' if stated else 'State height_m if the place is high. '}Correct what is wrong, or "
            f"delete gravity_m_s2: it follows from latitude_deg and height_m"
        )


def _rates(config: Config) -> Problems:
    for name, rate in config.rate.items():
        if isinstance(rate, KnownRateSection):
            share, key = rate.sd_rad_s / abs(rate.rate_rad_s), ("rate", name, "sd_rad_s")
        else:
            share, key = rate.timebase.relative_sd, ("rate", name, "timebase")
        if share > LARGEST_SHARE:
            yield key, (
                f"an sd of {100 * share:.3g} % of the rate determines no scale; at most "
                f"{100 * LARGEST_SHARE:g} % is accepted. State how well the rate is really known"
            )


def _files_of_two_runs(config: Config) -> Problems:
    seen: dict[tuple[Key, Path], PathTo] = {}
    for keys, run in config.placed_runs():
        place = (*keys, "poses")
        for path in (*run.poses.files, *run.poses.log):
            first = seen.setdefault((keys[0], path.resolve()), place)
            # One long log may hold the poses at rest and those on the plate.
            if first != place and path not in run.poses.log:
                yield place, (
                    f"{path} is in {path_text(first)} as well, and its samples would count twice. "
                    f"Name each file in the run that it was recorded in"
                )
                return


def _headings(config: Config) -> Problems:
    section = config.installation
    if section is None:
        return
    seen = {path.resolve(): "log" for path in section.log}
    for key in ("reverse_log", "drive_log"):
        for path in getattr(section, key):
            other = seen.setdefault(path.resolve(), key)
            if other != key:
                yield ("installation", key), (
                    f"{path} is the file of `{other}`; another recording is expected. "
                    f"`pipeline init` writes what each of them is"
                )
                return
