"""Names of the files and keys that a run writes."""

RESULTS_NAME = "results.json"
REPORT_NAME = "report.html"
REPORT_MARK = '<meta name="generator" content="pipeline run">'
"""Mark in every report, so that no other file is taken for one."""

PARAMETERS = ("misalignment_rad", "bias_counts", "scale_counts_per_unit")
"""Keys of the nine parameters of a triad and of their sds."""
