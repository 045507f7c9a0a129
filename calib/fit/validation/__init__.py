"""Errors of a fit at measurements that were not used in it.

    odd_poses: those that contradict all others, whatever the parameters
    leave_one_out: every pose by a fit without it;  wave_misfit: waves that fit no effect
    weak_directions: those that the poses hardly determine, and poses that nothing checks
    prediction: the sd of a corrected magnitude on the next log, by direction
    elsewhere: a pose that was excluded, all directions and times, an effect that is missing
"""
