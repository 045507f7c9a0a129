"""From one pose to one mean with an honest sd.

    pose_mean (the record) ─ sway ─ average_pose ─ drift_within (judged by the run's other poses)
                           common_course ─ correlation ─ mean_noise (of a run's means)
"""
