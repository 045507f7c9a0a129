"""Expected failures of a run, each with the exit code that tells a script what to do about it.

====  ==========================================================================
code  meaning
====  ==========================================================================
0     done; an effect found missing is a finding, not a failure
1     our bug
2     usage or configuration: change the command line or the YAML file
3     input that cannot be read: repair or replace the file
4     the data cannot determine what was asked: record more, or ask for less
5     the fit failed its own check
6     device, or a cluster, that does not answer
130   interrupted
====  ==========================================================================

Every message is one paragraph: where, what was found, what was expected, what to do next.
"""

import errno
import os
import platform
import shlex
import sys
import tempfile
import traceback
from types import TracebackType
from typing import ClassVar

#: Exit codes; their meanings are above, and in `pipeline --help`.
DONE, BUG, USAGE, UNREADABLE, UNDETERMINED, FIT_FAILED, DEVICE = range(7)
INTERRUPTED = 130  #: 128 and the number of SIGINT, as shells report it
SHOWN_PATH = 200  #: characters of a path that a message repeats
NO_MEMORY = ("The input needs more memory than this computer has free. Close other programs, or "
             "split the input into smaller files.")
INTERRUPTED_SAYS = "Interrupted. Every file is either complete or unchanged."


class PipelineError(Exception):
    """Base of all expected failures of this package."""

    exit_code: ClassVar[int] = USAGE


class ConfigError(PipelineError):
    """The configuration is wrong; ``problems`` has one paragraph for each mistake in the file."""

    def __init__(self, *problems: str) -> None:
        super().__init__("\n".join(problems))
        self.problems = problems


class MissingFiles(ConfigError):
    """The configuration is right, but files that it names are not there."""

    exit_code = UNREADABLE


class UnwritableOutput(PipelineError):
    """A result cannot be written at the requested place."""


class UnreadableInput(PipelineError):
    """An input file is missing, damaged, or not what its columns promise."""

    exit_code = UNREADABLE


class NoReadings(UnreadableInput):
    """A file is whole and holds no table of readings, as notes and pictures beside the logs do."""


class UnfinishedGuess(PipelineError):
    """What `pipeline import` has written does not run yet."""

    exit_code = UNDETERMINED


class UnfitCalibration(PipelineError):
    """The stored results do not determine what they are needed for."""

    exit_code = UNDETERMINED


class DeviceError(PipelineError):
    """A sensor, a camera or a cluster does not answer, or answers nonsense."""

    exit_code = DEVICE


#: Command or key to type, by the kind of a :class:`calib.errors.Remedy`.
TYPE_THIS = {
    "remove_effect": "`pipeline remove CONFIG TRIAD.NAME` takes an effect out of the model.",
    "data_sheet": "In the configuration they stand under sensor.{triad}.",
    "exclude_pose": "`pipeline exclude CONFIG TRIAD.NAME...` leaves out poses of a session; "
                    "bring further logs without them.",
    "default_solver": "In the configuration: `solver: default`.",
    "smaller_model": "In the configuration: {triad}: {{model: [{model}]}}.",
}


def message_of(error: BaseException) -> str:
    """The message of an expected failure, with what to type if that helps."""
    remedy = getattr(error, "remedy", None)
    if remedy is None:
        return str(error)
    advice = TYPE_THIS[remedy.kind].format(triad=remedy.triad, model=", ".join(remedy.model))
    message = str(error)
    return f"{message if message.endswith('.') else message + '.'} {advice}"


def exit_code_of(error: BaseException) -> int:
    """The exit code of an exception that ended a command; 1 for all unexpected ones."""
    from calib.effects.catalogue import UnknownEffect
    from calib.errors import CalibrationError, FitFailed, UnusableLog
    from vision.errors import UnreadableVideo, VisionError

    # The first match counts: a family's own base comes after its members.
    codes: tuple[tuple[type[BaseException], int], ...] = (
        (UnknownEffect, USAGE),
        (UnusableLog, UNREADABLE),
        (FitFailed, FIT_FAILED),
        (CalibrationError, UNDETERMINED),
        (UnreadableVideo, UNREADABLE),
        (VisionError, UNDETERMINED),
        (KeyboardInterrupt, INTERRUPTED),
    )
    if isinstance(error, PipelineError):
        return error.exit_code
    return next((code for family, code in codes if isinstance(error, family)), BUG)


#: Errors of a full or read-only system, and of exhausted resources.
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS)
EXHAUSTED = (errno.EIO, errno.EMFILE, errno.ENFILE, errno.ENOMEM)


def expected_failure(error: OSError | MemoryError) -> PipelineError:
    """A refusal of the system as an expected failure.

    Raises
    ------
    OSError
        It names no file and is no want of space, of memory or of the working folder: a bug.
    """
    if isinstance(error, MemoryError):
        return UnreadableInput(NO_MEMORY)
    where = "" if error.filename is None else f"{os.fsdecode(error.filename)[:SHOWN_PATH]}: "
    if error.errno in FULL:
        return UnwritableOutput(
            f"{where}cannot be written ({error.strerror}). Free the space, or choose another "
            f"folder with --output."
        )
    if not where and error.errno == errno.ENOENT:
        return UnreadableInput(
            "The working folder, or every folder for temporary files, does not exist any more. "
            "Change to another folder, and type the command again."
        )
    if not where and error.errno not in EXHAUSTED:
        raise error
    return UnreadableInput(
        f"{where}the system refuses it ({error.strerror}). Check the name, and that you may read "
        f"and write there."
    )


def report_bug(
    kind: type[BaseException], error: BaseException, trace: TracebackType | None
) -> None:
    """Save the traceback of an unexpected exception and print where; made for ``sys.excepthook``.

    Python itself then ends with exit code 1, and with 130 after Ctrl-C.
    """
    if issubclass(kind, KeyboardInterrupt):
        print(INTERRUPTED_SAYS, file=sys.stderr)
        return
    try:
        handle, path = tempfile.mkstemp(prefix="pipeline-bug-", suffix=".log", text=True)
        with os.fdopen(handle, "w", encoding="utf-8", errors="backslashreplace") as log:
            log.write(f"command: {shlex.join(sys.argv)}\n")
            log.write(f"python: {sys.version}\nplatform: {platform.platform()}\n\n")
            log.writelines(traceback.format_exception(kind, error, trace))
    except OSError:  # a full disk: only the screen is left
        traceback.print_exception(kind, error, trace)
        path = "what was printed above"
    print(
        f"This is our bug, not a fault in your data: {kind.__name__}: {error}. The command stopped "
        f"and results of earlier runs were left as they were. The details are in {path}; please "
        f"report it with that file and your config.yaml.",
        file=sys.stderr,
    )
