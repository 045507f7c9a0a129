"""Common parts of the commands: how they are typed, and their output while they run.

    group: the command by its name;  arguments: types of arguments;  output: --json and --quiet
    progress ─ run_with_progress ─ model_change: runs, with a line for each stage
    rate_outputs: the files of `rate`;  recording_display: the panel of a guided recording
"""
