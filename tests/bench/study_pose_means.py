"""Whether the sds of pose means hold: by length, by correlation of the noise, by converter steps.

    python -m tests.bench.study_pose_means

Every line is 60 sessions of 26 poses. Printed are the share of the means that lie within 1.96
stated sds of the truth, the spread of (mean - truth)/sd, by how much the variance exceeds what
batches state, with its scatter, and how many of the sessions are told that their poses are too
short.
"""

from tests.calib.poses.pose_mean_coverage import coverage

CASES = (
    (8, 0.5, 0), (8, 0.5, 3), (3, 0.5, 0), (3, 0.5, 3), (3, 0.5, 10), (1.5, 0.5, 0), (1.5, 0.5, 3),
    (3, 2.0, 0), (8, 2.0, 3), (8, 0.01, 3), (30, 0.5, 1),
)  # fmt: skip
STEPS = (0.5, 2.0, 5.0, 20.0)


def main() -> None:
    """Print both tables."""
    print("pose [s]  correlated over [s]  white   within 1.96 sd  spread  factor        noted")
    for seconds, tau_s, white in CASES:
        held = coverage(seconds, tau_s, white)
        print(f"{seconds:8g}  {tau_s:19g}  {white:5g}   {100 * held.covered:12.1f} %  "
              f"{held.spread:6.2f}  {held.factor:.2f} ± {held.factor_sd:.2f}  "
              f"{100 * held.noted:6.0f} %")  # fmt: skip
    print("steps of a converter, in sds of one sample; poses of 8 s, white noise")
    for step in STEPS:
        held = coverage(8, 0.01, 0, step)
        print(f"{step:8g}  {100 * held.covered:12.1f} %  {held.spread:6.2f}")


if __name__ == "__main__":
    main()
