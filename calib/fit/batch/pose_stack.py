"""S pose sets with equal numbers of rows, side by side."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from calib.poses.imu_log import FloatArray, IntArray
from calib.poses.pose_set import PoseSet


@dataclass(frozen=True, eq=False)
class PoseStack:
    """S sets of n poses each; the k poses with a magnitude row stand before the m null poses.

    Parameters
    ----------
    reading, sd : array, shape (S, n, 3)
        Mean nominal readings and their sds, SI.
    magnitude : array, shape (S, k)
        Reference magnitudes, SI.
    reference_sd : array, shape (S, n)
        The part of the reference's sd that each pose has for itself, SI.
    common : array, shape (S, k, q)
        Sds of the common errors of the references, SI.
    expected : array, shape (S, m, 3)
        What the null poses should read, SI.
    order : array, shape (S, n)
        Which pose of its set each of them is.
    """

    reading: FloatArray
    sd: FloatArray
    magnitude: FloatArray
    reference_sd: FloatArray
    common: FloatArray
    expected: FloatArray
    order: IntArray

    def __len__(self) -> int:
        return len(self.reading)

    @property
    def turning(self) -> int:
        """Number k of poses with a magnitude row."""
        return int(self.magnitude.shape[1])

    @property
    def data_count(self) -> int:
        """Number of data rows of each set."""
        return self.turning + 3 * int(self.expected.shape[1])

    @classmethod
    def of(cls, sets: Sequence[PoseSet]) -> "PoseStack":
        """The stack of ``sets``, which are of one :func:`shape_of`."""
        is_null = np.array([poses.reference.magnitude for poses in sets]) == 0.0
        order = np.argsort(is_null, axis=1, kind="stable")
        k = int((~is_null[0]).sum())
        in_order = not is_null[:, :k].any()

        def sorted_rows(arrays: Sequence[FloatArray]) -> FloatArray:
            rows = np.array(arrays)
            if in_order:
                return rows
            index = order.reshape(order.shape + (1,) * (rows.ndim - 2))
            return np.take_along_axis(rows, index, axis=1)

        return cls(
            reading=sorted_rows([poses.reading for poses in sets]),
            sd=sorted_rows([poses.sd for poses in sets]),
            magnitude=sorted_rows([poses.reference.magnitude for poses in sets])[:, :k],
            reference_sd=sorted_rows([poses.reference.sd for poses in sets]),
            common=sorted_rows([poses.reference.common for poses in sets])[:, :k],
            expected=sorted_rows([poses.expected for poses in sets])[:, k:],
            order=order,
        )


def shape_of(poses: PoseSet) -> tuple[int, int, int]:
    """What sets must share to be stacked: poses turning, poses at rest, common errors."""
    reference = poses.reference
    turning = int(np.count_nonzero(reference.magnitude))
    return turning, len(reference.magnitude) - turning, len(reference.common_names)


def grouped(sets: Sequence[PoseSet], most: int) -> Iterator[IntArray]:
    """Indices of sets that can be stacked, at most ``most`` at a time.

    Parameters
    ----------
    sets : sequence of PoseSet
    most : int
        Sets in one stack.

    Yields
    ------
    array of int
        Together every index of ``sets`` once.
    """
    shapes: dict[tuple[int, int, int], list[int]] = {}
    for i, poses in enumerate(sets):
        shapes.setdefault(shape_of(poses), []).append(i)
    for indices in shapes.values():
        for first in range(0, len(indices), most):
            yield np.array(indices[first : first + most])
