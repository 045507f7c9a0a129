"""The entry point ``pipeline``: the commands, and the handling of errors.

Help is printed without importing click; everything else goes through
:mod:`pipeline.commands.interaction.group`, which imports a command's module when it is typed.
"""

import os
import sys
from collections.abc import Sequence
from typing import NoReturn

from pipeline.commands import front_page

#: The variable by which a shell asks click for completions.
COMPLETION = "_PIPELINE_COMPLETE"


def program() -> NoReturn:
    """Run the command that was typed and end the process with its exit code.

    Python ends threads that still compute by unwinding them, and C++ code (OpenCV, SciPy) aborts
    the process then, up to Python 3.13. An interrupted process with such a thread ends at once.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:  # closed by the caller: no file may take its number
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_RDWR), mode))
    code = main()
    if threads := sys.modules.get("threading"):
        from pipeline.errors import INTERRUPTED

        if code == INTERRUPTED and any(one.daemon for one in threads.enumerate()):
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
    sys.exit(code)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code (see :mod:`pipeline.errors`).

    Parameters
    ----------
    arguments : sequence of str, optional
        What follows the program's name; by default from ``sys.argv``.
    """
    typed = list(sys.argv[1:] if arguments is None else arguments)
    if typed in ([], ["-h"], ["--help"]) and COMPLETION not in os.environ:
        return _print_front_page()
    try:
        return _shown(typed)
    except MemoryError:  # also while an error is being reported
        from pipeline.errors import NO_MEMORY, UNREADABLE

        print(NO_MEMORY, file=sys.stderr)
        return UNREADABLE


def _shown(typed: list[str]) -> int:
    """Run a command whose output is shown as the terminal can; its exit code."""
    from pipeline.console.terminal import shown_streams, terminated_as_interrupted

    with shown_streams() as output, terminated_as_interrupted():
        code = _run(typed)
        output.flush()
        return code if output.fault is None else code or _unwritten(output.fault)


def _print_front_page() -> int:
    """Print the help; a reader that goes away (``| head``) has read enough."""
    try:
        print(front_page(), flush=True)
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0 if isinstance(error, BrokenPipeError) else _unwritten(error)
    return 0


def _unwritten(error: OSError) -> int:
    print(f"standard output cannot be written ({error.strerror}); any files were written all "
          f"the same. Free the space, or send the output elsewhere.", file=sys.stderr)
    return 2


def _run(typed: list[str]) -> int:
    """Hand ``typed`` to click; expected errors become one paragraph and an exit code."""
    # The matrices here are small: threads of the linear algebra only compete with the decoder.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # See no-color.org: any non-empty value switches colours off; None lets the terminal decide.
    color = False if os.environ.get("NO_COLOR") else None
    from pipeline.errors import (
        INTERRUPTED,
        INTERRUPTED_SAYS,
        PipelineError,
        exit_code_of,
        expected_failure,
        message_of,
        report_bug,
    )

    try:
        import click

        from calib.errors import CalibrationError
        from pipeline.commands.interaction.group import root
        from vision.errors import VisionError

        sys.excepthook = report_bug
        done = root.main(typed, prog_name="pipeline", standalone_mode=False, color=color)
    except KeyboardInterrupt:  # during the imports; click turns it into Abort later
        print(INTERRUPTED_SAYS, file=sys.stderr)
        return INTERRUPTED
    except (PipelineError, CalibrationError, VisionError) as error:
        print(message_of(error), file=sys.stderr)
        return exit_code_of(error)
    except OSError as error:
        expected = expected_failure(error)
        print(message_of(expected), file=sys.stderr)
        return exit_code_of(expected)
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except click.Abort:  # click's name for Ctrl-C and for end of input
        print(INTERRUPTED_SAYS, file=sys.stderr)
        return INTERRUPTED
    return done if isinstance(done, int) else 0
