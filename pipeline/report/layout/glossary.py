"""The terms of statistics and navigation that the page explains where they stand.

Every term is a link to its entry at the end of the page; the page's script shows the entry beside
the term for mouse, keyboard and touch.
"""

import re
from dataclasses import dataclass
from html import escape


@dataclass(frozen=True)
class Term:
    """One entry: its key in links, its name, the words that link to it, and what it means."""

    key: str
    name: str
    pattern: str
    meaning: str


TERMS = (
    Term("chi2-dof", "chi²/dof", r"chi²/dof",
         "chi² divided by the degrees of freedom. It is about 1 if the noise of the poses explains "
         "the residuals, and larger if the model misses something."),
    Term("chi2", "chi²", r"chi²(?!/dof)",
         "The sum of the squared residuals, each divided by its sd."),
    Term("dof", "degrees of freedom (dof)", r"degrees of freedom",
         "The number of equations minus the number of fitted parameters."),
    Term("p", "p", r"\bp(?= =| below)",
         "The probability that noise alone gives a chi² of this size or larger, if the model is "
         "right."),
    Term("loo", "leave-one-out error", r"leave-one-out",
         "The error of predictions: each pose is predicted from a fit to all other poses. If an "
         "effect reduces the residual but not this error, the model fits the noise."),
    Term("rms", "RMS", r"\bRMS\b", "Root mean square: the square root of the mean square."),
    Term("sd", "sd", r"\bsds?\b", "Standard deviation. The true value is within one sd of the "
         "stated value in 68 % of cases, and within two sds in 95 %."),
    Term("unit", "mm/s² and °/s", r"mm/s²|°/s",
         "Errors of the accelerometer are in mm/s² everywhere on this page, those of the gyroscope "
         "in °/s. Data sheets quote mg: 1 mg is 9.81 mm/s². The results file is in SI units."),
    Term("ppm", "ppm", r"\bppm\b", "Parts per million: 1000 ppm are 0.1 %."),
    Term("specific-force", "specific force", r"specific force",
         "What an accelerometer measures: acceleration minus gravity. At rest it points upwards "
         "and has the magnitude of gravity."),
    Term("misfit", "misfit", r"misfit", "The part of the residuals that noise does not explain."),
    Term("birge", "Birge ratio", r"Birge ratio",
         "The square root of chi²/dof. If the model does not explain the residuals, the stated sds "
         "are multiplied by this ratio."),
    Term("proof-mass", "proof mass", r"proof mass",
         "The small mass inside an inertial sensor whose motion the sensor measures."),
)
_CODE = re.compile(r"`([^`<]+)`")
_ANY = re.compile("|".join(f"(?P<t{i}>{term.pattern})" for i, term in enumerate(TERMS)))


def with_terms(text: str) -> str:
    """``text`` as HTML, escaped, with a link to the glossary at the first place of every term.

    What stands between backticks is set as code.

    >>> with_terms("1 < 2 ppm")
    '1 &lt; 2 <a class="term" href="#term-ppm">ppm</a>'
    """
    linked: set[str] = set()

    def link(match: re.Match[str]) -> str:
        term = next(t for i, t in enumerate(TERMS) if match[f"t{i}"] is not None)
        if term.key in linked:
            return match[0]
        linked.add(term.key)
        return f'<a class="term" href="#term-{term.key}">{match[0]}</a>'

    return _CODE.sub(r"<code>\1</code>", _ANY.sub(link, escape(text)))
