"""The commands, one module each, loaded only when typed.

To add a command: one line in :data:`COMMANDS`, and a module of that name in this package whose
``command`` is a click command. Slow imports (numpy, scipy, cv2, matplotlib, pydantic) are inside
the command's function or module, never here.
"""

from pipeline.text.tables import NARROWEST, WIDEST, prose_width, wrapped

#: Name -> (arguments, one line of help), in the order in which ``pipeline --help`` shows them.
COMMANDS: dict[str, tuple[str, str]] = {
    "run": ("CONFIG", "Measure the rates, calibrate, diagnose, and write the report."),
    "rate": ("VIDEO...", "Measure the rate of a plate from clips."),
    "clock": ("", "Measure the clock of a camera by filming this computer's screen."),
    "diagnose": ("CONFIG", "Print what the model misses and the next command to type."),
    "discover": ("CONFIG", "Look for a formula of an error that no listed effect describes."),
    "add": ("CONFIG TARGET", "Add an effect to the model and compare the errors."),
    "remove": ("CONFIG TARGET", "Remove an effect from the model and compare the errors."),
    "exclude": ("CONFIG POSE", "Leave a pose out of the fit and compare the errors."),
    "effects": ("[NAME]", "List all effects, or print the page of one effect."),
    "history": ("CONFIG", "List all runs with their models, errors and verdicts."),
    "open": ("CONFIG", "Run CONFIG and open its workbench in the browser."),
    "compare": ("A B [C...]", "Compare sessions of one sensor, or runs of one session."),
    "record": ("CONFIG", "Record poses from a sensor, or rehearse that with --demo."),
    "plan": ("CONFIG", "Print what the poses determine, before or after recording."),
    "demo": ("[DIR]", "Copy an example session and calibrate it."),
    "import": ("FILE...", "Write a configuration for logs of any tool."),
    "check": ("CONFIG", "Validate a configuration and find its files."),
    "init": ("[DIR]", "Write a commented config.yaml."),
    "fleet": ("GLOB", "Run many sessions on Dask, and compare the sensors of a lot."),
    "export": ("RESULTS", "Write the calibration in the format of another program."),
    "noise": ("LOG", "Determine noise density, bias instability and random walk."),
    "apply": ("RESULTS LOG", "Correct a log: counts in, SI units out."),
}
#: Commands that scripts know by another name -> their present form.
KEPT: dict[str, tuple[str, ...]] = {"ports": ("record", "--ports")}
ABOUT = (
    "Calibrate a low-cost IMU with a record player, a webcam and a YAML file, and determine which "
    "errors the model does not describe."
)
AFTER = (
    "Tab completion: eval \"$(_PIPELINE_COMPLETE=bash_source pipeline)\" in ~/.bashrc; with "
    "zsh_source or fish_source in the other shells. NO_COLOR=1 switches colours off.",
    "`pipeline COMMAND --help` explains a command and shows examples. Results go to standard "
    "output, progress and warnings to standard error.",
    "Exit codes: 0 done, 1 error of this program, 2 wrong usage or configuration, 3 unreadable "
    "input, 4 the data cannot determine the result, 5 the fit failed its own check, 6 device "
    "error, 130 interrupted.",
)


def front_page() -> str:
    """Output of ``pipeline --help``; written without click, whose import alone takes longer."""
    width = prose_width() or WIDEST
    names = {name: f"{name} {arguments}" for name, (arguments, _) in COMMANDS.items()}
    column = 2 + max(map(len, names.values())) + 2
    lines = ["Usage: pipeline COMMAND ...", "", *wrapped(ABOUT, width), ""]
    for name, (_, summary) in COMMANDS.items():
        first, *rest = wrapped(summary, max(width - column, NARROWEST // 2))
        lines.append(f"  {names[name]:<{column - 2}}{first}")
        lines += [f"{'':<{column}}{line}" for line in rest]
    for paragraph in AFTER:
        lines += ["", *wrapped(paragraph, width)]
    return "\n".join(lines)


def paragraph(text: str, indent: str = "") -> str:
    """``text`` wrapped at the terminal's width; one line where programs read it."""
    width = prose_width()
    return text if width is None else "\n".join(wrapped(text, width, indent))


def examples(*lines: str) -> str:
    r"""The end of a command's help; the \b keeps click from joining the lines."""
    return "\n".join(["\b", "Examples:", *(f"  {line}" for line in lines)])
