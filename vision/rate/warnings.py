"""What is said beside a rate that stands all the same."""

import numpy as np

from vision.phase_track import RateHistory
from vision.rate.camera_roll import CameraRoll
from vision.rate.stability import HIDING, angle_step

SCATTERED_RAD = np.radians(0.7)  # about an even rotation; ten times what a poor film gives


def lost_pictures(source: str, history: RateHistory, noise_rad: float) -> tuple[str, ...]:
    """Pictures found lost silently, or that none could be found."""
    angle = history.angle
    lost = int(angle.dropped.sum())
    if lost:
        return (
            f"{source}: {lost} picture(s) were lost without a trace in the time stamps "
            f"({lost / len(angle.time_s):.1%}): the angle jumps by whole frame times. Their time "
            f"was put back, so the rate stands.",
        )
    step = angle_step(history)
    if noise_rad < HIDING * step:
        return ()
    return (
        f"{source}: the plate turns by {np.degrees(step):.2f}° from picture to picture and the "
        f"angle scatters by {np.degrees(noise_rad):.2f}°: a picture that the recorder lost would "
        f"not be noticed, and one in a hundred makes the rate 1 % too high. With fewer pictures "
        f"per second, or a bold mark, it would be.",
    )


def scattered_angle(source: str, noise_rad: float, rate_rad_s: float) -> tuple[str, ...]:
    """An angle further off an even rotation than a plate goes."""
    if noise_rad < SCATTERED_RAD:
        return ()
    return (
        f"{source}: the angle scatters by {np.degrees(noise_rad):.1f}° about an even rotation, "
        f"where a plate filmed from a stand gives some hundredths: noisy pictures, time stamps "
        f"that are late by {1e3 * noise_rad / abs(rate_rad_s):.0f} ms, a camera that moves, or "
        f"something that is no plate. The uncertainty counts it; see in the annotated picture what "
        f"was followed.",
    )


def rolling_camera(source: str, roll: CameraRoll | None, rate_rad_s: float) -> tuple[str, ...]:
    """A camera that rolled while it filmed."""
    if roll is None:
        return ()
    share = abs(roll.rate_rad_s / rate_rad_s)
    return (
        f"{source}: the camera rolled by {np.degrees(roll.range_rad):.1f}° while it filmed, as "
        f"what lies around the plate shows. Of the rate {share * 1e6:.0f} ppm may be the camera's "
        f"own; the sd has them. Fix the camera to a stand and film again.",
    )
