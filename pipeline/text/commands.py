"""Commands of this program as they are typed, for every line that proposes one."""

import shlex
from pathlib import Path


def command(*words: str | Path) -> str:
    """The command with these words, each as a shell reads it.

    >>> command("add", "my log.yaml", "gyroscope.column:Fan speed [1/min]")
    "pipeline add 'my log.yaml' 'gyroscope.column:Fan speed [1/min]'"
    """
    return " ".join(["pipeline", *map(word, words)])


def word(text: str | Path) -> str:
    """A word of a command as a shell reads it; a file whose name begins with ``-`` is no option.

    >>> word(Path("-a.yaml"))
    './-a.yaml'
    """
    is_option_like = isinstance(text, Path) and str(text).startswith("-")
    return shlex.quote(f"./{text}" if is_option_like else str(text))
