"""A simulated device: a recorded session on a pseudo-terminal, to rehearse a recording.

    session ─ device ─ pseudo_port
"""

from typing import Literal, get_args

Protocol = Literal["xsens-mti", "sketch", "a/g", "binary"]
PROTOCOLS: tuple[Protocol, ...] = get_args(Protocol)  #: that the simulated device speaks
