"""Closed-form evidence and signatures against brute force."""

from itertools import product

import numpy as np
import pytest

from calib.diagnosis.constants import CONSTANTS
from calib.diagnosis.diagnose import diagnose
from calib.diagnosis.hypotheses.signature import (
    Projector,
    are_aliases,
    contains,
    effect_columns,
    whole_columns,
)
from calib.diagnosis.search.evidence import (
    TAUS,
    Noise,
    Sets,
    block_log_densities,
)
from calib.effects.catalogue import BASE, find_effect
from calib.effects.effect import EFFECTS
from calib.fit.least_squares.solver import fit
from calib.fit.model import Model
from calib.fit.rows.residuals import Equations
from calib.fit.triad.calibration import calibrate_triad
from tests.calib.made_poses import (
    SLOW,
    SPECS,
    base_theta,
    made_poses,
    noisy,
    read_through,
    rich_poses,
    with_noise,
)

MODEL = Model.of(BASE)


def gaussian(r: np.ndarray, cov: np.ndarray) -> float:
    """Log density of ``r`` under N(0, cov), less that under N(0, I)."""
    _, logdet = np.linalg.slogdet(cov)
    return float(-0.5 * logdet - 0.5 * r @ np.linalg.solve(cov, r) + 0.5 * r @ r)


def density(r: np.ndarray, columns: list[np.ndarray], taus: tuple[float, ...]) -> float:
    """Log density of ``r`` under unit noise and blocks of these sizes, no constants."""
    cov = np.eye(len(r))
    for block, tau in zip(columns, taus, strict=True):
        cov = cov + tau**2 * block @ block.T
    return gaussian(r, cov) - 0.5 * float(r @ r)


def prior(tau: float) -> float:
    """Log prior of one size: half-Cauchy over the octaves."""
    def at(size: float) -> float:
        return size / (1 + (size / CONSTANTS.typical_size) ** 2)

    return float(np.log(at(tau) / sum(at(float(size)) for size in TAUS)))


def of_blocks(
    strength: np.ndarray, amplitude: np.ndarray, chi2: float, dof: int
) -> np.ndarray:
    """Blocks of one residual."""
    return block_log_densities(strength, amplitude, chi2, known(dof))


def known(dof: int) -> Noise:
    """Noise whose variance is known, as that of infinitely many degrees of freedom."""
    return Noise(dof, 1e9)


def nothing(chi2: float, dof: int) -> float:
    return float(np.logaddexp(*known(dof).nothing(chi2)))


def one_set(x: np.ndarray, r: np.ndarray, sizes: tuple[int, ...]) -> Sets:
    """The set of blocks ``x`` (n, p) about a residual of n rows."""
    last = sum(sizes[:-1])
    x = x.copy()
    x[:, last:] = x[:, last:] @ np.linalg.svd(x[:, last:])[2].T  # orthogonal, its span as it was
    gram, product = x.T @ x, x.T @ r
    block = np.repeat(np.arange(len(sizes) - 1), sizes[:-1])
    return Sets(gram[None, :last], np.diag(gram)[None, last:], product[None], block[None],
                np.array([sizes]), float(r @ r), known(len(r)))


@pytest.mark.parametrize("seed", range(3))
def test_the_closed_form_of_one_block_is_the_density_of_its_covariance(seed: int) -> None:
    """The residual is short, so that the stated noise holds and V is 1."""
    rng = np.random.default_rng(seed)
    n, v = 14, 3
    basis = np.linalg.qr(rng.standard_normal((n, v)))[0]
    strength = rng.uniform(0.5, 4, v)
    r = 0.5 * rng.standard_normal(n) + basis @ (2 * strength * rng.standard_normal(v))
    brute = np.logaddexp.reduce(
        [prior(tau) + density(r, [basis * strength], (tau,)) for tau in TAUS]
    )
    one = of_blocks(strength[None], (basis.T @ r)[None], r @ r, n)
    assert one[0] == pytest.approx(float(brute), abs=1e-6)
    x = basis * strength
    several = one_set(x, r, (v,)).averaged()[0]
    assert several == pytest.approx(float(brute), abs=1e-5)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("rows", "size", "widths"), [
    (20, 4.0, (3, 2)),  # both are plain
    (20, 0.3, (3, 3)),  # neither shows
    (9, 2.0, (3, 9)),  # together they fill all degrees of freedom
    (40, 2.0, (3, 26)),
    (20, 2.0, (2, 3, 2)),
])
def test_a_set_averages_over_the_size_of_each_of_its_blocks(
    rows: int, size: float, widths: tuple[int, ...], seed: int
) -> None:
    """One size at a time with the others at their likeliest, against all of them together."""
    rng = np.random.default_rng(seed)
    blocks = [rng.standard_normal((rows, v)) / np.sqrt(v) for v in widths]
    r = sum(b @ (size * rng.standard_normal(b.shape[1])) for b in blocks) + 0.9 * (
        rng.standard_normal(rows)
    )
    brute = np.logaddexp.reduce([
        sum(map(prior, taus)) + density(r, blocks, taus)
        for taus in product(map(float, TAUS), repeat=len(widths))])
    noise = one_set(np.concatenate(blocks, axis=1), r, widths)
    assert noise.averaged()[0] == pytest.approx(float(brute), abs=0.4)
    assert noise.averaged()[0] < noise.at_most()[0]


def test_blocks_of_fewer_directions_are_padded_with_zeros() -> None:
    rng = np.random.default_rng(5)
    strength, amplitude = rng.uniform(0.1, 3, (1, 2)), rng.standard_normal((1, 2))
    padded = [np.pad(values, ((0, 0), (0, 3))) for values in (strength, amplitude)]
    alone = of_blocks(strength, amplitude, 15.0, 20)
    assert of_blocks(*padded, 15.0, 20) == pytest.approx(alone)


def test_larger_noise_is_believed_as_the_residual_grows() -> None:
    odds = [larger - stated for stated, larger in
            (known(30).nothing(chi2) for chi2 in (30.0, 45.0, 90.0, 900.0))]
    assert odds == sorted(odds)
    assert odds[0] < 0 < odds[2]


def test_parameters_that_buy_nothing_cost() -> None:
    zeros = np.zeros((1, 3))
    small = of_blocks(np.ones((1, 1)), zeros[:, :1], 20.0, 20)[0]
    large = of_blocks(np.ones((1, 3)), zeros, 20.0, 20)[0]
    assert large < small < known(20).nothing(20.0)[0]


@pytest.mark.parametrize("size", [30.0, 300.0, 3000.0])
def test_more_signal_never_means_less_evidence(size: float) -> None:
    """An effect that leaves 2 % of itself keeps its odds however strong it is."""
    rng = np.random.default_rng(3)
    basis = np.linalg.qr(rng.standard_normal((40, 3)))[0]

    def odds(of: float) -> float:
        r = of * basis @ np.ones(3) + 0.02 * of * rng.standard_normal(40) / np.sqrt(40)
        chi2 = float(r @ r)
        one = of_blocks(np.full((1, 3), 6.0), (basis.T @ r)[None], chi2, 40)[0]
        return float(one - nothing(chi2, 40))

    assert odds(2 * size) > odds(size) - 3
    assert odds(size) > 20


def test_huge_misfits_do_not_tie() -> None:
    """Where p-values underflow the evidence still tells strong from stronger."""
    one, two = (
        of_blocks(np.full((1, 3), 6.0), np.full((1, 3), a), 7 * a**2, 20)[0]
        for a in (1e4, 2e4)
    )
    assert np.isfinite([one, two]).all()
    assert one > two + 10


def test_probabilities_sum_to_one_and_nothing_leads_on_clean_poses() -> None:
    found = diagnose(fit(noisy(rich_poses("gyroscope"), 2), MODEL))
    total = sum(c.probability for c in found.ranking)
    assert 0 < total < 0.5
    assert [c.probability for c in found.ranking] == sorted(
        (c.probability for c in found.ranking), reverse=True
    )


@pytest.mark.parametrize("freedom", [3.0, 30.0])
def test_noise_that_few_samples_know_is_averaged_over_its_variance(freedom: float) -> None:
    """The density is that of a variance with its inverse chi-square distribution."""
    rng = np.random.default_rng(8)
    x, r = 3 * rng.standard_normal((12, 2)), 2 * rng.standard_normal(12)
    tau = 4.0
    cov = np.eye(12) + tau**2 * x @ x.T
    q, log_det = float(r @ np.linalg.solve(cov, r)), float(np.linalg.slogdet(cov)[1])
    v = np.exp(np.linspace(-12, 12, 40001))
    weight = v ** (-0.5 * freedom) * np.exp(-0.5 * freedom / v)
    inside = weight * v**-6.0 * np.exp(-0.5 * q / v) * np.exp(-0.5 * log_det)
    exact = np.log(inside.sum() / (weight * v**-6.0 * np.exp(-0.0 / v)).sum())
    stated, _ = Noise(12, freedom).log_density(np.array([q]), np.array([log_det]), float(r @ r))
    assert stated[0] == pytest.approx(exact, abs=1e-6)


def test_what_the_model_absorbs_is_projected_out() -> None:
    found = fit(noisy(rich_poses("gyroscope"), 3), MODEL)
    projector = Projector(found)
    assert np.abs(projector(found.rows.jacobian)).max() < 1e-6 * np.abs(found.rows.jacobian).max()
    assert projector.residual == pytest.approx(found.rows.residual, abs=1e-5)


@pytest.mark.parametrize(
    "name", ["quadratic", "g_sensitivity", "warm_up", "scale_drift", "reference_offset"]
)
def test_the_columns_are_what_the_effect_would_leave(name: str) -> None:
    """Columns times a small size are the change of the rows when the effect enters the model."""
    base = fit(noisy(rich_poses("gyroscope"), 4), MODEL)
    effect = EFFECTS[name]
    columns = whole_columns(base, effect)
    with_it = Model.of((*BASE, name))
    equations = Equations.of(base.poses, with_it)
    size = 1e-6 * np.arange(1.0, len(effect.parameters) + 1)
    shapes = {} if effect.shape is None else {name: effect.shape.starts[0]}
    there = equations.rows(np.concatenate([base.theta, -size]), base.eta, shapes).residual
    moved = there - base.rows.residual
    expected = columns @ size
    assert moved[: len(expected)] == pytest.approx(expected, abs=2e-4 * np.abs(expected).max())


def test_aliases_are_symmetric_and_of_one_dimension() -> None:
    found = fit(noisy(made_poses("gyroscope", (SLOW,), jitter_deg=0.5), 5), MODEL)
    projector = Projector(found)
    signature = {
        name: projector.signature(name, effect_columns(found, find_effect(name)))
        for name in ("quadratic", "g_squared_sensitivity", "cubic", "scale_drift",
                     "reference_drift", "frame_rotation", "g_sensitivity")
    }
    assert are_aliases(signature["quadratic"], signature["g_squared_sensitivity"])
    assert are_aliases(signature["g_squared_sensitivity"], signature["quadratic"])
    assert not are_aliases(signature["quadratic"], signature["cubic"])
    assert contains(signature["scale_drift"], signature["reference_drift"])
    assert not contains(signature["reference_drift"], signature["scale_drift"])
    assert signature["frame_rotation"].is_blind
    assert signature["g_sensitivity"].is_blind


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("quadratic", (2e-3, -1e-3, 1.5e-3)),
        ("reference_drift", (4e-3,)),
        ("bias_drift", (1e-3, -2e-3, 1e-3)),
    ],
)
def test_the_predicted_size_is_what_the_refit_then_finds(
    name: str, size: tuple[float, ...]
) -> None:
    model = Model.of((*BASE, name))
    theta = base_theta(model, "gyroscope")
    theta[9:] = size
    poses = with_noise(read_through(rich_poses("gyroscope"), model, theta),
                       np.random.default_rng(6))
    before = diagnose(fit(poses, MODEL))
    predicted = next(c for c in before.ranking if c.name == name)
    value, sd = calibrate_triad(fit(poses, model), SPECS["gyroscope"]).effect_values()[name]
    assert name in before.group
    # Linearised at a biased fit, the prediction is off by some per cent.
    assert predicted.size == pytest.approx(value, rel=0.1)
    assert predicted.sd == pytest.approx(sd, rel=0.2)
    assert np.abs(value - theta[9:]).max() < 4 * sd.max()
