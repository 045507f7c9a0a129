"""Errors of a fit at measurements that were not used in it.

    leave_one_out: every pose by a fit without it
    predicted_pose: a pose that was excluded
    prediction: the sd of a corrected magnitude on the next log, by direction
    missing_effect: what an effect that the model lacks adds to it
"""
