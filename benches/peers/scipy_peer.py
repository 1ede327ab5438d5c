"""SciPy on one problem: see trueaxis/problem.rs for the folders, `run` for the calls.

    scipy_peer.py PROBLEM NAME TIMES

prints the seconds of each solve and leaves NAME.solution in the folder of the problem.
"""

import sys
import time
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.sparse import csr_matrix

TOLERANCE = 1e-10
# With the defaults, steps are so rough that it ends 1e-4 mm and more beside the minimum.
STEPS = {"atol": 1e-12, "btol": 1e-12, "regularize": False}
# All trials cost the same; these are enough for a median.
MOST_TRIALS = 10


def rows(path):
    return np.loadtxt(path, delimiter=",", ndmin=2) if path.stat().st_size else np.empty((0, 0))


class Lengths:
    """|p - S| - L minus the measured lengths; unknowns are all points, then all stations."""

    def __init__(self, folder):
        points, stations = rows(folder / "points.csv"), rows(folder / "stations.csv")
        lengths = rows(folder / "lengths.csv")
        self.point_count = len(points)
        self.start = np.concatenate([points.ravel(), stations.ravel()])
        self.station, self.point = lengths[:, 0].astype(int), lengths[:, 1].astype(int)
        self.measured_mm = lengths[:, 2]
        columns = np.empty((len(lengths), 7), dtype=np.int32)
        columns[:, :3] = 3 * self.point[:, None] + np.arange(3)
        columns[:, 3:] = points.size + 4 * self.station[:, None] + np.arange(4)
        self.columns = columns.ravel()
        self.ends = np.arange(0, 7 * len(lengths) + 1, 7, dtype=np.int32)

    def split(self, unknowns):
        points = unknowns[: 3 * self.point_count].reshape(-1, 3)
        return points, unknowns[3 * self.point_count :].reshape(-1, 4)

    def beams(self, unknowns):
        points, stations = self.split(unknowns)
        return points[self.point] - stations[self.station, :3], stations[self.station, 3]

    def residuals(self, unknowns):
        beams, dead_paths = self.beams(unknowns)
        return np.sqrt(np.einsum("ij,ij->i", beams, beams)) - dead_paths - self.measured_mm

    def jacobian(self, unknowns):
        beams, _ = self.beams(unknowns)
        beams /= np.sqrt(np.einsum("ij,ij->i", beams, beams))[:, None]
        values = np.full((len(beams), 7), -1.0)
        values[:, :3] = beams
        values[:, 3:6] = -beams
        shape = (len(beams), len(unknowns))
        return csr_matrix((values.ravel(), self.columns, self.ends), shape=shape)

    def solve(self):
        return least_squares(
            self.residuals,
            self.start,
            self.jacobian,
            method="trf",
            tr_solver="lsmr",
            ftol=TOLERANCE,
            xtol=TOLERANCE,
            gtol=TOLERANCE,
            tr_options=STEPS,
        )


def main():
    folder, name, times = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    problem = Lengths(folder)
    lengths_mm = problem.measured_mm
    trials = rows(folder / "trials.csv")
    # The last trial is the one whose solutions are compared.
    lengths = [lengths_mm + errors for errors in trials[-MOST_TRIALS:]] or [lengths_mm] * times
    for measured_mm in lengths:
        problem.measured_mm = measured_mm
        start = time.perf_counter()
        solution = problem.solve()
        print(time.perf_counter() - start)
        if not solution.success:
            sys.exit(f"not converged: {solution.message}")
    points, stations = problem.split(solution.x)
    with open(folder / f"{name}.solution", "w") as file:
        np.savetxt(file, points, fmt="%.17g", delimiter=",")
        np.savetxt(file, stations, fmt="%.17g", delimiter=",")


if __name__ == "__main__":
    main()
