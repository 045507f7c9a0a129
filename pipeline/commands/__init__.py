"""The commands, one module each, loaded only when typed.

To add a command: one line in :data:`COMMANDS`, and a module of that name in this package whose
``command`` is a click command. Whatever is slow to import (numpy, scipy, cv2, matplotlib,
pydantic) is imported inside the command's function or module, never here.
"""

#: name -> (arguments, one line of help), in the order in which ``pipeline --help`` shows them.
COMMANDS: dict[str, tuple[str, str]] = {
    "run": ("CONFIG", "Measure the rate, calibrate, diagnose; write the report."),
    "rate": ("VIDEO...", "Measure a plate's rate from clips, nothing else."),
    "diagnose": ("CONFIG", "Say what the model misses, and what to type next."),
    "add": ("CONFIG TARGET", "Put an effect into the model; before → after. Also --auto."),
    "remove": ("CONFIG TARGET", "Take an effect out of the model again."),
    "effects": ("[NAME]", "The catalogue of effects, or one effect's page."),
    "history": ("CONFIG", "Every run so far: model, errors, verdict."),
    "ports": ("", "List serial ports, and what keeps you from opening them."),
    "record": ("CONFIG", "Record poses live, led through them; goes on where it stopped."),
    "plan": ("CONFIG", "What the poses determine, before and after recording; what next."),
    "playback": ("CONFIG", "Play recorded poses as a serial device, to try `record`."),
    "check": ("CONFIG", "Validate a configuration and find its files, nothing else."),
    "init": ("[DIR]", "Write a commented config.yaml to start from."),
    "export": ("RESULTS", "Write the calibration for another program."),
    "apply": ("RESULTS LOG", "Correct a log: counts in, SI units out."),
}


def front_page() -> str:
    """What ``pipeline --help`` prints; written without click, whose import alone takes longer."""
    width = max(len(f"{name} {arguments}") for name, (arguments, _) in COMMANDS.items())
    lines = [f"  {f'{name} {arguments}':<{width}}  {says}" for name, (arguments, says) in
             COMMANDS.items()]
    return "\n".join(
        [
            "Usage: pipeline COMMAND ...",
            "",
            "Calibrate a low-cost IMU with a record player, a webcam and a YAML file, and find",
            "what the model misses.",
            "",
            *lines,
            "",
            "`pipeline COMMAND --help` explains one command. Results go to standard output,",
            "progress and warnings to standard error.",
            "Exit codes: 0 done, 1 our bug, 2 usage or config, 3 unreadable input, 4 the data",
            "cannot determine what was asked, 5 the fit failed its own check, 6 device,",
            "130 interrupted.",
        ]
    )
