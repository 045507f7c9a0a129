"""The sections of a factory certificate."""

from pipeline.config.types import Section, Three


class TriadCertificateSection(Section):
    """A factory certificate's values of one triad, to lay beside the estimate."""

    bias_counts: Three
    scale_counts_per_unit: Three
    misalignment_rad: Three | None = None
    alignment: tuple[Three, Three, Three] | None = None


class CertificateSection(Section):
    """The factory certificate."""

    accelerometer: TriadCertificateSection | None = None
    gyroscope: TriadCertificateSection | None = None
