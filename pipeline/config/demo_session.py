"""The example session that comes with the program: where it is, and a copy of it."""

import shutil
import tempfile
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path

from pipeline.errors import UnreadableInput, UnwritableOutput
from pipeline.text.names import DISTRIBUTION

SESSION = "hidden_effect"
CONFIG = "config.yaml"


def session_folder() -> Path:
    """The folder of the example session: in a checkout, or where the wheel has put it.

    Raises
    ------
    UnreadableInput
        It is in neither place.
    """
    checkout = Path(__file__).parents[2] / "data" / SESSION
    if (checkout / CONFIG).is_file():
        return checkout
    try:
        installed = files(DISTRIBUTION) or []
    except PackageNotFoundError:
        installed = []
    for path in installed:
        if path.parts[-2:] == (SESSION, CONFIG):
            return Path(str(path.locate())).parent
    raise UnreadableInput(f"the example session is neither in {checkout} nor among the files of "
                          f"{DISTRIBUTION}. Install the program again.")


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
        # Whole or not at all: a copy that is cut off has another name, and goes with its block.
        with tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}.") as part:
            whole = Path(part) / SESSION
            shutil.copytree(session_folder(), whole, ignore=shutil.ignore_patterns("*.run"))
            whole.rename(folder)
    except OSError as error:
        reason = error.strerror or "the disk may be full"
        raise UnwritableOutput(f"{folder}: cannot be written ({reason}). Name another "
                               "folder.") from error
    return folder / CONFIG
