"""The commented configuration that ``pipeline init`` writes."""

from importlib.resources import files
from pathlib import Path

from pipeline.errors import ConfigError
from pipeline.files import write_whole

TEMPLATE_NAME = "config.yaml"
TILTED = """\
# Both triads from the turning plate: put 5 cm under one side of the record player, which makes 9°
# of tilt, and a rubber mat under the sensor. Gravity then goes round in every pose. One file for
# each of nine or more mountings, 20 s long (five turns): the six faces up and three edges or more.
# CSV with the header time_s,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z and, if available, temperature_c.
"""
#: What is recorded of them instead.
RECORDED = {
    "  poses: 18                      # 6 faces, 12 edges; 26 with the corners\n":
    "  poses: 9                       # 6 faces, 3 edges; 18 with all edges\n",
    "  seconds_per_pose: 10           #": "  seconds_per_pose: 20           #",
}


def template_text() -> str:
    """The template, a valid configuration once its files are there."""
    return files("pipeline.config").joinpath("templates", TEMPLATE_NAME).read_text(encoding="utf-8")


def site_text(latitude_deg: float, height_m: float) -> str:
    """The section ``site`` of a place."""
    return f"{{latitude_deg: {latitude_deg:g}, height_m: {height_m:g}}}"


def located_template(text: str, latitude_deg: float, height_m: float) -> str:
    """The template with the line of the site stating where that is."""
    lines = text.splitlines(keepends=True)
    site = f"site: {site_text(latitude_deg, height_m)}\n"
    return "".join(site if line.startswith("site:") else line for line in lines
                   if not line.startswith("# with your values."))


def tilted_template(text: str) -> str:
    """The template with both triads from the turning plate, which leans."""
    run = "    - {poses: gyroscope/tilted/pose_*.csv, rate: slow}\n"
    text = text.replace("a sensor in 18 poses, a turning plate,",
                        "a sensor in nine poses on a turning plate that leans,", 1)
    head, accelerometer, rest = text.partition("# Poses at rest, one file for each")
    below = (accelerometer + rest).partition("accelerometer:\n")[2]
    below = below.replace("  poses: accelerometer/pose_*.csv\n", f"  runs:\n{run}", 1)
    between, _, last = below.partition("gyroscope:\n  runs:\n")
    last = last.split("rate: stopped}\n", 1)[1]
    between = between.replace("# The same poses on the turning plate, and with the plate stopped.",
                              "# The same logs.")
    for line, instead in RECORDED.items():
        last = last.replace(line, instead, 1)
    return f"{head}{TILTED}accelerometer:\n{between}gyroscope:\n  runs:\n{run}{last}"


def write_template(folder: Path, text: str) -> Path:
    """Write ``config.yaml`` into ``folder``, made where it is missing, and return its path.

    Raises
    ------
    ConfigError
        There is a ``config.yaml`` already; it is left as it is.
    """
    path = folder / TEMPLATE_NAME
    if path.exists() or path.is_symlink():
        raise ConfigError(
            f"{path}: exists already and is left as it is. Name another folder, "
            f"as in `pipeline init my-session`, or move the file away."
        )
    write_whole(path, text)
    return path
