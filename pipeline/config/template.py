"""The commented configuration that ``pipeline init`` writes."""

from importlib.resources import files
from pathlib import Path

from pipeline.errors import ConfigError
from pipeline.files import write_whole

TEMPLATE_NAME = "config.yaml"


def template_text() -> str:
    """The template, a valid configuration once its files are there."""
    return files("pipeline.config").joinpath("templates", TEMPLATE_NAME).read_text(encoding="utf-8")


def site_text(latitude_deg: float, height_m: float) -> str:
    """The section ``site`` of a place."""
    return f"{{latitude_deg: {latitude_deg:g}, height_m: {height_m:g}}}"


def at_site(text: str, latitude_deg: float, height_m: float) -> str:
    """The template with the line of the site stating where that is."""
    lines = text.splitlines(keepends=True)
    site = f"site: {site_text(latitude_deg, height_m)}\n"
    return "".join(site if line.startswith("site:") else line for line in lines
                   if not line.startswith("# with your values."))


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
