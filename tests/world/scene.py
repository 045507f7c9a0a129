"""What stands in front of the camera of the simulated bench.

The plate lies in the plane z = 0 with unit radius; x points right and y up in an untilted picture,
so that a positive angle turns counter-clockwise as filmed.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Mark:
    """A rectangle of tape: centre radius and azimuth on the plate, size along radius and across.

    Grey unless ``blue`` or ``red``, its Cb and Cr less those of grey, are given.
    """

    radius: float = 0.88
    azimuth_rad: float = 0.0
    length: float = 0.16
    width: float = 0.09
    luma: float = 225.0
    blue: float = 0.0
    red: float = 0.0


@dataclass(frozen=True)
class Scene:
    """Everything about the picture except how the plate turns.

    Lengths on the plate are in plate radii, brightness in luma steps of 8-bit limited-range video
    (16 black, 235 white), angles in radians.
    """

    width_px: int = 480
    height_px: int = 360
    centre_px: tuple[float, float] = (231.0, 183.0)
    radius_px: float = 143.0
    tilt_rad: float = 0.0
    tilt_azimuth_rad: float = -np.pi / 2  # towards the viewer: the near side is down
    camera_distance: float = 6.0  # from the spindle, in plate radii
    plate_luma: float = 48.0
    deck_luma: float = 105.0
    marks: tuple[Mark, ...] = (Mark(),)
    deck_mark_azimuth_rad: float | None = -1.75
    label: bool = True
    sensor_box: bool = True
    texture: float = 0.0  # standard deviation of a speckle all over the plate
    tonearm: bool = False
    hand_until_s: float = 0.0
    glare: float = 40.0
    shading: float = 0.25  # relative fall of the light across the picture
    light: float = 1.0  # scales everything: dim pictures
    flicker: float = 0.0  # relative, at flicker_hz
    flicker_hz: float = 1.3
    noise: float = 2.0  # standard deviation per pixel and frame, luma steps
    exposure_s: float = 1 / 60
    line_time_s: float = 0.0  # rolling shutter: delay from one picture row to the next
    chroma_noise: float = 0.0  # the same in Cb and Cr
    colour: bool = True

    @property
    def coloured_marks(self) -> bool:
        """The plate is to be followed by its colour, which then is rendered with all care."""
        return any(mark.blue or mark.red for mark in self.marks)


def random_scene(rng: np.random.Generator) -> Scene:
    """One of the many pictures a user may send: tilt 0 to 40°, noise, blur, glare, clutter."""
    tilt = np.radians(rng.uniform(0, 40))
    n_marks = rng.choice([0, 1, 1, 1, 2, 3])
    marks = tuple(
        Mark(
            radius=rng.uniform(0.7, 0.9),
            azimuth_rad=rng.uniform(0, 2 * np.pi),
            length=rng.uniform(0.1, 0.18),
            width=rng.uniform(0.06, 0.12),
            luma=rng.choice([225.0, 200.0, 170.0]),
        )
        for _ in range(n_marks)
    )
    return Scene(
        centre_px=(240 + rng.uniform(-25, 25), 180 + rng.uniform(-12, 12)),
        radius_px=rng.uniform(110, 150),
        tilt_rad=tilt,
        tilt_azimuth_rad=rng.uniform(-np.pi, 0),
        camera_distance=rng.uniform(4, 8),
        plate_luma=rng.uniform(30, 70),
        deck_luma=rng.uniform(85, 150),
        marks=marks,
        deck_mark_azimuth_rad=rng.uniform(0, 2 * np.pi) if rng.random() < 0.8 else None,
        label=bool(n_marks == 0 or rng.random() < 0.8),
        sensor_box=bool(n_marks == 0 or rng.random() < 0.8),
        texture=rng.uniform(0, 3) if rng.random() < 0.3 else 0.0,
        tonearm=bool(rng.random() < 0.3),
        hand_until_s=rng.uniform(1, 4) if rng.random() < 0.25 else 0.0,
        glare=rng.uniform(0, 90),
        shading=rng.uniform(0, 0.5),
        light=rng.uniform(0.6, 1.0),
        flicker=rng.uniform(0, 0.02) if rng.random() < 0.3 else 0.0,
        noise=rng.uniform(1, 5),
        exposure_s=rng.uniform(1 / 250, 1 / 25),
        line_time_s=rng.uniform(0, 30e-3) / 360 if rng.random() < 0.5 else 0.0,
    )


def colour_scene(rng: np.random.Generator) -> Scene:
    """Such a picture in which only marks of colour turn, as bright as the plate."""
    scene = random_scene(rng)
    marks = []
    for _ in range(rng.choice([1, 1, 2, 3])):
        hue, saturation = rng.uniform(0, 2 * np.pi), rng.uniform(15, 70)
        marks.append(
            Mark(
                radius=rng.uniform(0.7, 0.9),
                azimuth_rad=rng.uniform(0, 2 * np.pi),
                length=rng.uniform(0.1, 0.18),
                width=rng.uniform(0.06, 0.12),
                luma=scene.plate_luma,
                blue=saturation * np.cos(hue),
                red=saturation * np.sin(hue),
            )
        )
    return replace(
        scene,
        marks=tuple(marks),
        label=False,
        sensor_box=False,
        texture=0.0,
        chroma_noise=rng.uniform(0.5, 3),
    )


def homography(scene: Scene) -> FloatArray:
    """Plate coordinates (radii, y up) to pixel coordinates, shape (3, 3), pinhole camera."""
    ca, sa = np.cos(scene.tilt_azimuth_rad), np.sin(scene.tilt_azimuth_rad)
    ct, st = np.cos(scene.tilt_rad), np.sin(scene.tilt_rad)
    d = scene.camera_distance
    turn = np.array([[ca, sa], [-sa, ca]])  # along the tilt, across it
    # The part along the tilt is foreshortened and comes nearer to the camera.
    squeeze = np.diag([ct, 1.0]) @ turn
    back = turn.T @ squeeze
    depth = np.array([-st * ca / d, -st * sa / d])
    focal = scene.radius_px
    to_px = np.array([[focal, 0, scene.centre_px[0]], [0, -focal, scene.centre_px[1]], [0, 0, 1.0]])
    plane = np.zeros((3, 3))
    plane[:2, :2] = back
    plane[2, :2] = depth
    plane[2, 2] = 1.0
    return to_px @ plane
