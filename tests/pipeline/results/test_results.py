"""results.json: the contract of its keys, and what is said of one that is none."""

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.errors import UnreadableInput
from pipeline.results.read import load_results
from tests.pipeline.conftest import RunSession
from tests.sessions import results_in

TRIAD_KEYS = {
    "model", "n_poses", "chi2", "dof", "p_value", "residual_rms", "loo_rms", "iterations",
    "parameters", "sd", "effects", "poses", "diagnosis",
}
NINE = {"misalignment_rad", "bias_counts", "scale_counts_per_unit"}
RATE_KEYS = {
    "rate_rad_s", "sd_rad_s", "direction", "revolutions", "frames", "phase_rms_rad", "frame_count",
    "sd_parts", "diagnosis", "clips",
}
DIAGNOSIS_KEYS = {"verdict", "name", "group", "says", "record_next", "ranking"}
CANDIDATE_KEYS = {
    "name", "log_evidence", "chi2_drop", "size", "sd", "rms_after", "loo_after", "blind", "aliases",
}


@pytest.fixture
def found(finished: RunSession) -> dict[str, Any]:
    return results_in(finished.folder)


def leaves(value: Any) -> Iterator[Any]:
    """Every plain value inside."""
    if isinstance(value, dict):
        for child in value.values():
            yield from leaves(child)
    elif isinstance(value, list):
        for child in value:
            yield from leaves(child)
    else:
        yield value


def test_the_contract_s_keys_are_there(found: dict[str, Any]) -> None:
    assert found["format"] == 1
    assert set(found) >= {"rate", "accelerometer", "gyroscope", "installation"}
    assert found["rate"]["17rpm"].keys() >= RATE_KEYS
    assert found["rate"]["17rpm"]["sd_parts"].keys() == {"image_rad_s", "timebase_rad_s"}
    for triad in ("accelerometer", "gyroscope"):
        assert found[triad].keys() >= TRIAD_KEYS
        assert found[triad]["parameters"].keys() == found[triad]["sd"].keys() == NINE
        assert found[triad]["diagnosis"].keys() >= DIAGNOSIS_KEYS
        assert len(found[triad]["poses"]) == found[triad]["n_poses"] == 18
        assert all(p.keys() >= {"label", "run", "residual", "sd"} for p in found[triad]["poses"])
        for candidate in found[triad]["diagnosis"]["ranking"]:
            assert candidate.keys() == CANDIDATE_KEYS
    assert "frame_to_accelerometer_rad" in found["gyroscope"]


def test_the_figures_are_those_of_the_poses(found: dict[str, Any]) -> None:
    for triad in ("accelerometer", "gyroscope"):
        poses = found[triad]["poses"]
        residual = np.array([pose["residual"] for pose in poses])
        left_out = np.array([pose["left_out"] for pose in poses])
        assert found[triad]["residual_rms"] == pytest.approx(np.sqrt(np.mean(residual**2)))
        assert found[triad]["loo_rms"] == pytest.approx(np.sqrt(np.mean(left_out**2)))
        assert found[triad]["dof"] == 18 - 9
        corrected = np.array([pose["corrected"] for pose in poses])
        reference = np.array([pose["reference"] for pose in poses])
        # The reference of a pose may still shift by the error that all poses have in common.
        away = np.linalg.norm(corrected, axis=1) - reference - residual
        assert np.ptp(away) < 1e-9


def test_the_parts_of_every_sd_add_up_to_it(found: dict[str, Any]) -> None:
    for triad in ("accelerometer", "gyroscope"):
        for key, sd in found[triad]["sd"].items():
            parts = [np.array(part[key]) for part in found[triad]["sd_parts"].values()]
            assert np.sqrt(sum(part**2 for part in parts)) == pytest.approx(np.array(sd), rel=1e-9)
    assert found["gyroscope"]["sd_parts"].keys() == {"noise", "rate 17rpm"}
    assert found["accelerometer"]["sd_parts"].keys() == {"noise"}  # gravity was stated as exact


def test_blind_effects_stand_last_and_without_numbers(found: dict[str, Any]) -> None:
    ranking = found["gyroscope"]["diagnosis"]["ranking"]
    blind = [each["name"] for each in ranking if each["blind"]]
    assert blind == found["gyroscope"]["diagnosis"]["blind"]
    assert {"g_sensitivity", "reference_scale"} <= set(blind)  # one speed, plate never stopped
    assert [each["name"] for each in ranking[-len(blind) :]] == blind
    assert all(each["log_evidence"] is None and each["size"] == [] for each in ranking[-2:])


def test_what_a_stated_rate_cannot_tell_is_null(found: dict[str, Any]) -> None:
    rate = found["rate"]["17rpm"]
    for key in ("revolutions", "frames", "phase_rms_rad", "frame_count", "diagnosis", "direction"):
        assert rate[key] is None, key
    assert rate["clips"] == []


def test_it_names_no_absolute_path_and_no_time_of_day(
    finished: RunSession, found: dict[str, Any]
) -> None:
    texts = [leaf for leaf in leaves(found) if isinstance(leaf, str)]
    assert not any(str(finished.config.parent) in text for text in texts)
    assert found["accelerometer"]["poses"][0]["label"] == "accelerometer/pose_01.csv"
    assert not any(":" in text and "T" in text and text[:2] == "20" for text in texts)


def test_numbers_are_numbers_or_null_as_json_has_them(finished: RunSession) -> None:
    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    text = (finished.folder / "results.json").read_text(encoding="utf-8")
    json.loads(text, parse_constant=refuse)


def test_gravity_and_its_sd_are_stated_with_their_source(found: dict[str, Any]) -> None:
    assert found["accelerometer"]["gravity"] == {
        "value_m_s2": 9.80267, "sd_m_s2": 0.0, "source": "stated",
    }


# --- reading it back ---------------------------------------------------------------------------


def test_read_back_it_holds_the_same_calibration(
    finished: RunSession, found: dict[str, Any]
) -> None:
    for given in (finished.folder, finished.folder / "results.json"):
        stored = load_results(given)
        assert [each.name for each in stored.triads] == ["accelerometer", "gyroscope"]
        gyroscope = stored.triads[1]
        bias = gyroscope.parameters.bias_counts
        assert bias.tolist() == found["gyroscope"]["parameters"]["bias_counts"]
        matrix, offset = gyroscope.correction.linear_form()
        nominal = gyroscope.correction.spec.nominal(bias)
        assert matrix @ nominal + offset == pytest.approx(np.zeros(3), abs=1e-12)


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda found: "{", "is not JSON"),
        (lambda found: json.dumps([1]), "format None found, 1 is expected"),
        (lambda found: json.dumps({**found, "format": 2}), "format 2 found, 1 is expected"),
        (lambda found: json.dumps(_without(found, "gyroscope", "sd")), "a part is missing"),
        (lambda found: json.dumps(_without(found, "gyroscope", "correction", "theta")), "a part"),
    ],
)
def test_what_is_no_results_file_is_refused_with_what_to_do(
    found: dict[str, Any], tmp_path: Path, spoil: Any, says: str
) -> None:
    (tmp_path / "results.json").write_text(spoil(found), encoding="utf-8")
    with pytest.raises(UnreadableInput, match=rf"results\.json: {says}.*pipeline run"):
        load_results(tmp_path)


def test_a_missing_file_is_refused_with_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(UnreadableInput, match=r"results\.json: cannot be read .*pipeline run"):
        load_results(tmp_path)


def _without(found: dict[str, Any], *keys: str) -> dict[str, Any]:
    spoilt: dict[str, Any] = copy.deepcopy(found)
    inner = spoilt
    for key in keys[:-1]:
        inner = inner[key]
    del inner[keys[-1]]
    return spoilt
