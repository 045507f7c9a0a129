"""What a search weighs: a set of hypotheses, and a class of effects with its probability."""

from dataclasses import dataclass
from typing import NamedTuple

from calib.diagnosis.search.candidates import Members
from calib.diagnosis.search.refit import Refit


class Entry(NamedTuple):
    """One set of hypotheses: its members' indices and its log posterior, not normalised.

    ``refit`` is the joint refit of all its members, where one was made.
    """

    members: Members
    log_posterior: float
    refit: Refit | None = None

    @property
    def explains(self) -> bool:
        """Whether the joint refit of all its members explains the rows."""
        return self.refit is not None and self.refit.explains


@dataclass(frozen=True)
class Inclusion:
    """A class of effects and the probability that one of them is missing.

    Attributes
    ----------
    name : str
        Its most probable member.
    members : tuple of str
        All, ``name`` first.
    probability : float
    kind : str
        That of the hypothesis ``name``, or ``noise``.
    follows : str or None
        What ``name`` is a function of where it is an unknown function.
    details : tuple of str
        The poses or times of what is not an effect, the leading set's first.
    errs : str
        What of the reading an unknown function is, where the rows tell.
    """

    name: str
    members: tuple[str, ...]
    probability: float
    kind: str
    follows: str | None = None
    details: tuple[str, ...] = ()
    errs: str = ""
