"""Files that come with the program: the commented template, the example session, the pictures.

The session and the pictures are in ``data``, in a checkout as in an installation.
"""

import shutil
import tempfile
from importlib import resources
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

from pipeline.errors import ConfigError, UnreadableInput, UnwritableOutput
from pipeline.files import write_whole
from pipeline.text.names import DISTRIBUTION

TEMPLATE_NAME = "config.yaml"


def site_text(latitude_deg: float, height_m: float) -> str:
    """The section ``site`` of a place."""
    return f"{{latitude_deg: {latitude_deg:g}, height_m: {height_m:g}}}"


def template_text(site: str | None = None, tilted: bool = False) -> str:
    """The template, a valid configuration once its files are there.

    Parameters
    ----------
    site : str, optional
        Its section of this name; by default gravity anywhere on Earth.
    tilted : bool
        Whether both triads are read on a turning plate that leans.
    """
    from jinja2 import Template  # which other users of this module do not need

    template = resources.files("pipeline.config").joinpath("templates", TEMPLATE_NAME)
    filled = Template(
        template.read_text(encoding="utf-8"), trim_blocks=True, keep_trailing_newline=True)
    text: str = filled.render(site=site, tilted=tilted)
    return text


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


SESSION = "hidden_effect"
CONFIG = "config.yaml"


def shipped_file(folder: str, name: str) -> Path:
    """A file of ``data``: in a checkout, or where the wheel installed it.

    Raises
    ------
    UnreadableInput
        It is in neither place.
    """
    checkout = Path(__file__).parents[2] / "data" / folder / name
    if checkout.is_file():
        return checkout
    try:
        installed = files(DISTRIBUTION) or []
    except PackageNotFoundError:
        installed = []
    for path in installed:
        if path.parts[-2:] == (folder, name):
            return Path(str(path.locate()))
    raise UnreadableInput(f"{name} is neither {checkout} nor among the files of {DISTRIBUTION}. "
                          f"Install the program again.")


def session_folder() -> Path:
    """The folder of the example session.

    Raises
    ------
    UnreadableInput
        It is not among the files of the installation.
    """
    return shipped_file(SESSION, CONFIG).parent


def copy_session(folder: Path) -> Path:
    """Copy the example session to ``folder`` and return its configuration.

    Raises
    ------
    UnwritableOutput
        ``folder`` exists and holds something, or cannot be written.
    UnreadableInput
        The session is not among the files of the installation.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UnwritableOutput(f"{folder}: exists and is left as it is. Name another folder, as in "
                               "`pipeline demo my-demo`, or run the session in it with "
                               f"`pipeline run {folder / CONFIG}`.")
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        # Whole or not at all: an interrupted copy has another name, and is removed with its block.
        with tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}.") as part:
            whole = Path(part) / SESSION
            shutil.copytree(session_folder(), whole, ignore=shutil.ignore_patterns("*.run"))
            whole.rename(folder)
    except OSError as error:
        reason = error.strerror or "the disk may be full"
        raise UnwritableOutput(f"{folder}: cannot be written ({reason}). Name another "
                               "folder.") from error
    return folder / CONFIG
