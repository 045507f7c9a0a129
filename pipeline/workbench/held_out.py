"""A second session of the sensor: its poses are predicted by every calibration, fitted by none."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from calib.fit.triad.calibration import TriadCalibration
from calib.fit.triad.correction import Correction
from calib.poses.imu_log import Triad
from pipeline.errors import ConfigError, PipelineError
from pipeline.results.comparison import StoredPoses, rms, share_a_reading
from pipeline.results.json_values import Json
from pipeline.results.names import RESULTS_NAME
from pipeline.results.read import Stored, load_results
from pipeline.text.formatting import DISPLAY


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Name of the session, and the calibration and the poses of each of its triads."""

    name: str
    triads: Mapping[str, tuple[Correction, StoredPoses]]

    @classmethod
    def of(cls, stored: Stored) -> "HeldOut":
        """The session of a results.json."""
        return cls(stored.contents.title or stored.folder.with_suffix("").name, {
            triad.name: (triad.correction, StoredPoses.of(triad))
            for triad in stored.triads})

    @classmethod
    def of_bytes(cls, content: bytes) -> "HeldOut":
        """The session of a dropped results.json.

        Raises
        ------
        ConfigError, UnreadableInput
            It is none.
        """
        with TemporaryDirectory() as folder:
            path = Path(folder) / RESULTS_NAME
            path.write_bytes(content)
            try:
                return cls.of(load_results(path))
            except PipelineError as error:  # its message names an unknown file
                raise ConfigError(str(error).replace(str(path), "the file")) from error

    def predicted(
        self, triad: Triad, correction: Correction, of_file: TriadCalibration
    ) -> Json:
        """Error of a calibration on these poses, in the shown unit of the triad.

        Parameters
        ----------
        triad : str
        correction : Correction
        of_file : TriadCalibration
            That of the session's file, whose fit must not have seen these poses.

        Returns
        -------
        dict
            ``labels``, ``residual``, ``sd`` and ``rms``, and ``own_rms``, the error of the held-out
            session's own calibration, None where it cannot be evaluated; or ``problem``, why there
            are none.
        """
        if triad not in self.triads:
            return {"problem": f"{self.name} has no {triad}."}
        fitted_to_them, poses = self.triads[triad]
        if fitted_to_them.spec != correction.spec:
            return {"problem": f"{self.name} has another data sheet of the {triad}: a count of the "
                               f"one is no count of the other."}
        if share_a_reading(poses.at.vector, of_file.fit.poses.reading):
            return {"problem": f"{self.name} has the very measurements of this session, so its "
                               f"poses are no test. Choose a session that was recorded apart."}
        errors, by_own = poses.errors(correction), poses.errors(fitted_to_them)
        if errors is None:
            return {"problem": f"{self.name} does not hold what an effect of this model needs."}
        factor = DISPLAY[triad][1]
        return {"labels": list(poses.label), "residual": (errors * factor).tolist(),
                "sd": (poses.sd * factor).tolist(), "rms": rms(errors) * factor,
                "own_rms": None if by_own is None else rms(by_own) * factor}
