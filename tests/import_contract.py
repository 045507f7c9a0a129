"""The import contract: which module may import what; held by tests/test_architecture.py."""

from collections.abc import Mapping

#: Where each dependency may be imported: a module, or all whose names begin so.
HOME: Mapping[str, tuple[str, ...]] = {
    "numpy": ("pipeline", "vision", "calib"),
    "scipy": ("pipeline", "vision", "calib"),
    "cv2": ("vision",),
    "serial": ("pipeline.record",),
    "yaml": ("pipeline.config", "pipeline.export"),
    "pydantic": ("pipeline.config", "pipeline.results.schema"),
    "pydantic_core": ("pipeline.config",),
    "jinja2": ("pipeline.report", "pipeline.export", "pipeline.config.template"),
    "rich": ("pipeline.cli", "pipeline.commands"),
    "starlette": ("pipeline.served", "pipeline.workbench", "pipeline.clock"),
    "uvicorn": ("pipeline.served",),
    "filelock": ("pipeline.session_folder",),
    "matplotlib": ("pipeline.report.noise_figure", "calib.notebook"),
    "click": ("pipeline.cli", "pipeline.commands"),
    "rosbags": ("pipeline.logs.formats.ros",),
    "pyulog": ("pipeline.logs.formats.px4",),
    "pymavlink": ("pipeline.logs.formats.ardupilot",),
    "pyarrow": ("pipeline.logs.formats.parquet", "pipeline.fleet.lot_table"),
    "distributed": ("pipeline.fleet.cluster",),
    "h5py": ("pipeline.logs.formats.hdf5",),
    "pandas": ("calib.notebook", "pipeline.fleet"),
    "av": ("vision.video.av_decoder",),
    "allantools": ("calib.noise.allan",),
    "threadpoolctl": ("calib.threads",),
}
#: Installed by an extra: what reads them says which where they are missing.
EXTRAS = {"rosbags": "ros", "pyulog": "px4", "pymavlink": "ardupilot", "pyarrow": "parquet",
          "h5py": "hdf5", "av": "fields", "pandas": "notebook", "allantools": "noise",
          "distributed": "fleet"}
#: Which of our packages each may import besides itself.
MAY_IMPORT: Mapping[str, set[str]] = {
    "pipeline": {"vision", "calib"}, "vision": set(), "calib": set(),
}
#: The way of the data inside a folder: a room imports from itself and from the floors before it,
#: never from one after it. Rooms in one tuple do not import each other.
FLOORS: Mapping[str, list[tuple[str, ...]]] = {
    "calib": [
        ("errors", "earth", "rounding", "numbers", "spelling", "threads"), ("poses",),
        ("effects",), ("fit",),
        ("diagnosis", "mounting", "consistency", "noise"),
        ("planning", "assess", "lot", "discovery"), ("notebook",),
    ],
    "calib.poses": [
        ("triad_kind", "rows"), ("imu_log",),
        ("data_sheet", "conditions", "reference", "attitudes"), ("samples",), ("checks",),
        ("averaging", "rests"), ("runs",), ("pose_set",), ("past",),
    ],
    "calib.poses.averaging": [
        ("pose_mean",), ("sway",), ("average_pose",),
        ("correlation", "common_course"), ("drift_within", "mean_noise"),
    ],
    "calib.poses.rests": [
        ("still_search",), ("rest_candidates", "attitude_fit"), ("static_intervals",),
    ],
    "calib.poses.runs": [
        ("ring",), ("pose_run",), ("reference_runs",), ("ideal_ring",),
    ],
    "calib.fit": [
        ("model", "linear", "stacked", "noise_size"), ("parameters",),
        ("rows",), ("least_squares",), ("triad",), ("validation",),
    ],
    "calib.fit.least_squares": [
        ("identifiability", "square_start", "gauss_newton"), ("result",),
        ("visible_basis", "finish", "widened"),
        ("stack_fits", "drawn_sizes"), ("solver", "angrisano"),
        ("unknown_sd",),
    ],
    "calib.fit.triad": [
        ("correction", "determined"), ("within_poses",),
        ("calibration", "frame_alignment", "leaning"),
        ("other_poses",),
    ],
    "calib.fit.validation": [
        ("leave_one_out", "odd_poses", "wave_misfit"), ("weak_directions",), ("prediction",),
        ("elsewhere", "untold"),
    ],
    "calib.noise": [("stillness", "allan"), ("coefficients",)],
    "calib.notebook": [("tables", "display"), ("calibration",), ("from_table",)],
    "calib.discovery": [("functions",), ("response",), ("grammar",), ("screen",), ("discover",),
                        ("together",)],
    "calib.diagnosis": [
        ("constants",), ("hypotheses",), ("search",), ("next_measurement",), ("verdict",),
        ("finding", "averaged", "stand_ins"), ("diagnose",),
        ("absorbed", "population"), ("formula_error",), ("unseen",), ("grounds",),
    ],
    "calib.diagnosis.hypotheses": [
        ("columns", "signature"), ("filmed",), ("listed",), ("courses", "unlisted"),
    ],
    "calib.diagnosis.search": [
        ("evidence",), ("table", "refit"), ("table_at", "candidates"), ("entry", "what_errs"),
        ("posterior",), ("imitation",), ("search",),
    ],
    "calib.diagnosis.verdict": [
        ("explanation",), ("ranking", "wording", "kinds_of_noise", "beside"), ("decision",),
        ("case",), ("explain",),
    ],
    "vision": [
        ("geometry", "numbers"), ("phase_track",),
        ("image_return", "drawing"), ("errors",),
        ("video", "camera"),
        ("plate", "rate"), ("tracking", "overlay"), ("clip_rate", "live_plate"),
    ],
    "vision.video": [("orientation", "reduction", "av_decoder"), ("reader",)],
    "pipeline": [
        ("errors", "text"), ("drawings", "files"), ("logs", "cameras", "served"), ("devices",),
        ("config",), ("stages",),
        ("results", "record", "plan", "model_change", "exclusion", "guess", "clock"),
        ("next_change", "further"), ("console", "export"), ("report",), ("session_folder",),
        ("fleet", "workbench", "notebook"), ("commands",),
        ("cli",),
        ("__main__",),
    ],
    "pipeline.report": [
        ("page_templates",), ("triad",), ("plate", "mounting_view", "noise_figure"), ("page",),
    ],
}
