"""results.json: the results of a run, for programs.

SI units, arrays in the order x, y, z, null for what was not determined. The same input gives the
same file, byte for byte: it holds no time of day and no absolute path.
"""

import hashlib
import json

from pipeline.results.certificate import certificate_json
from pipeline.results.json_values import Json
from pipeline.results.mounting import mounting_json
from pipeline.results.rate import rate_json
from pipeline.results.schema import FORMAT
from pipeline.results.triad import triad_json
from pipeline.stages.certificate import compare_with_certificate
from pipeline.stages.run import Outcome


def config_sha256(outcome: Outcome) -> str:
    """The SHA-256 of the configuration's text, which identifies it."""
    return hashlib.sha256(outcome.config.source.text.encode()).hexdigest()


def results_of(outcome: Outcome) -> Json:
    """The results of a run as plain values, as results.json has them."""
    results: Json = {
        "format": FORMAT,
        "title": outcome.config.title,
        "sensor": outcome.config.sensor.name,
        "config_sha256": config_sha256(outcome),
        "session_start_s": outcome.recordings.origin_s if outcome.triads else None,
        "rate": {name: rate_json(rate) for name, rate in outcome.rates.items()},
        "accelerometer": None,
        "gyroscope": None,
        "installation": mounting_json(outcome.installation) if outcome.installation else None,
        "warnings": list(outcome.warnings),
    }
    for result in outcome.triads:
        certificate = compare_with_certificate(outcome.config, result)
        results[result.triad] = triad_json(
            result, outcome.config.effects, outcome.config.source.path.parent
        ) | {
            "certificate": certificate_json(certificate) if certificate else None
        }
    return results


def results_text(results: Json) -> str:
    """The text of ``results.json``."""
    return json.dumps(results, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
