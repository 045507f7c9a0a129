"""Results of a lot in words: for the page and for the terminal."""

from calib.diagnosis.population.pool import FALSE_ALARM, PooledEffect
from calib.diagnosis.population.random_effects import RandomEffects
from calib.effects.units import display_unit
from calib.rounding import with_sd
from pipeline.fleet.population import TriadPopulation
from pipeline.text.formatting import count

CLEAR_SDS = 2.0
"""Size in sds from which it is quoted; derived: 95 % of a normal distribution."""


def pool_headline(population: TriadPopulation) -> str:
    """Effects that the lot lacks, by name."""
    pooled = population.pool
    if pooled is None or not pooled.effects:
        return pool_text(population)
    return f"Missing in the lot: {'; '.join(map(_named, pooled.effects))}."


def pool_text(population: TriadPopulation) -> str:
    """Effects that the lot lacks, or that it lacks none, in one paragraph."""
    pooled = population.pool
    if pooled is None:
        return "No evidence of single sessions is kept, so nothing was pooled."
    lot = f"{count(len(population.rows), 'session')} of {count(len(pooled.sensors), 'sensor')}"
    if not pooled.effects:
        return (f"Nothing is missing in the lot: the evidence of {lot}, added up, shows none of "
                f"{count(len(pooled.candidates), 'candidate')} (false alarms in "
                f"{100 * FALSE_ALARM:.0f} % of lots).")
    return f"Pooled over {lot}: " + " ".join(effect_text(effect) for effect in pooled.effects)


def p_text(p_value: float) -> str:
    """A probability as usually written.

    >>> p_text(0.25), p_text(3e-7), p_text(0.0)
    ('0.25', '3e-07', 'below 1e-300')
    """
    return f"{p_value:.2g}" if p_value > 1e-300 else "below 1e-300"


def effect_text(effect: PooledEffect) -> str:
    """One effect that the lot lacks."""
    form = ("of one size in all sensors" if effect.evidence.p_common < effect.evidence.p_any
            else "of sizes that differ between sessions")
    return (f"{_named(effect)} is missing, {form}, p {p_text(effect.evidence.p_value)}. "
            f"{sizes_text(effect)}")


def _named(effect: PooledEffect) -> str:
    also = f" (or {', '.join(effect.alternatives)})" if effect.alternatives else ""
    return f"'{effect.name}'{also}"


def sizes_text(effect: PooledEffect) -> str:
    """Common size and spread of the parameters that the lot shows clearly."""
    trial = effect.evidence.trial
    unit, factor = display_unit(trial.unit, [size.mean for size in effect.sizes if size])
    parts = [
        f"{name} {with_sd(factor * size.mean, factor * size.mean_sd)}{_spread(size, factor)}"
        for name, size in zip(trial.parameters, effect.sizes, strict=True)
        if size is not None and (abs(size.mean) > CLEAR_SDS * size.mean_sd or
                                 size.spread > CLEAR_SDS * size.spread_sd)
    ]
    if not parts:
        return ""
    return f"Common size and spread over the sensors, {unit}: {'; '.join(parts)}."


def _spread(size: RandomEffects, factor: float) -> str:
    if size.spread <= CLEAR_SDS * size.spread_sd:
        return ""
    return f", spread {with_sd(factor * size.spread, factor * size.spread_sd)}"


def parameter_name(name: str) -> str:
    """A column of the table in words.

    >>> parameter_name("scale_counts_per_unit_x")
    'scale x'
    """
    key, _, axis = name.rpartition("_")
    return f"{key.partition('_')[0]} {axis}"


def copies_text(population: TriadPopulation) -> str:
    """Number of sessions that repeat another one; empty where none does."""
    if not population.copies:
        return ""
    copy, original = next(iter(population.copies.items()))
    verb = "has" if len(population.copies) == 1 else "have"
    return (f"{count(len(population.copies), 'session')} {verb} the very measurements of another "
            f"one, which count once: '{copy}' is '{original}'.")


def is_unrepeatable(population: TriadPopulation) -> bool:
    """Whether the sessions of a sensor differ by more than their sds."""
    repeats = population.repeats
    return any(repeat.p_value * len(repeats) < FALSE_ALARM for repeat in repeats)


def repeat_text(population: TriadPopulation) -> str:
    """Whether the stated sds hold from session to session, in one sentence."""
    if not population.repeats:
        return ("No sensor has two sessions, so that nothing is known of its repeatability. "
                "{sensor} in the pattern names the sensor of a session.")
    worst = max(population.repeats, key=lambda repeat: repeat.birge)
    if is_unrepeatable(population):
        return (f"Parameters differ from session to session by more than is stated: "
                f"{parameter_name(worst.name)} "
                f"by {worst.birge:.1f} times its sd (Birge ratio, {worst.dof} degrees of freedom).")
    return (f"The stated sds hold from session to session: the largest Birge ratio is "
            f"{worst.birge:.2f} ({parameter_name(worst.name)}, {worst.dof} degrees of freedom).")
