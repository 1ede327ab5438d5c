"""Recomputes circle3d/*.orth: the circle of least orthogonal distance, in 60-digit arithmetic.

    python3 orthogonal_circles.py        compares with the files (needs mpmath)

Minimises sum h^2 + (rho - R)^2 over centre, normal and radius, h the distance of a point from the
plane of the circle and rho its distance from the axis, by Gauss-Newton from NIST's two-step
circle (.fit). It shares no code and no parametrisation with the crate: the six unknowns here are
the centre, two slopes of the normal, and R, with derivatives by differences.
"""

from pathlib import Path

import mpmath as mp

mp.mp.dps = 60
H = mp.mpf(10) ** -25  # step of the central differences: truncation 1e-50, rounding 1e-35
HERE = Path(__file__).parent / "circle3d"


def numbers(path):
    return [mp.mpf(word) for word in path.read_text().split()]


def basis(normal):
    """Two unit vectors across a unit normal."""
    least = min(range(3), key=lambda i: abs(normal[i]))
    a = [mp.mpf(i == least) - normal[least] * normal[i] for i in range(3)]
    length = mp.sqrt(sum(x * x for x in a))
    a = [x / length for x in a]
    b = [normal[(i + 1) % 3] * a[(i + 2) % 3] - normal[(i + 2) % 3] * a[(i + 1) % 3] for i in range(3)]
    return a, b


def circle(unknowns, normal):
    a, b = basis(normal)
    tilted = [normal[i] + unknowns[3] * a[i] + unknowns[4] * b[i] for i in range(3)]
    length = mp.sqrt(sum(x * x for x in tilted))
    return unknowns[:3], [x / length for x in tilted], unknowns[5]


def residuals(points, unknowns, normal):
    centre, normal, radius = circle(unknowns, normal)
    out = []
    for point in points:
        arm = [p - c for p, c in zip(point, centre)]
        h = sum(x * n for x, n in zip(arm, normal))
        rho = mp.sqrt(sum((x - h * n) ** 2 for x, n in zip(arm, normal)))
        out += [h, rho - radius]
    return mp.matrix(out)


def fit(points, start):
    centre, normal, radius = start[:3], start[3:6], start[6] / 2
    for _ in range(60):
        length = mp.sqrt(sum(x * x for x in normal))
        normal = [x / length for x in normal]
        unknowns = list(centre) + [mp.mpf(0), mp.mpf(0), radius]
        r = residuals(points, unknowns, normal)
        jacobian = mp.matrix(len(r), 6)
        for k in range(6):
            ahead, behind = list(unknowns), list(unknowns)
            ahead[k] += H
            behind[k] -= H
            jacobian[:, k] = (residuals(points, ahead, normal) - residuals(points, behind, normal)) / (2 * H)
        step = mp.lu_solve(jacobian.T * jacobian, -(jacobian.T * r))
        centre, normal, radius = circle([u + s for u, s in zip(unknowns, step)], normal)
        if mp.norm(step) < mp.mpf(10) ** -30:
            break
    return list(centre) + list(normal) + [2 * radius]


def main():
    for data in sorted(HERE.glob("*.ds")):
        values = numbers(data)
        points = [values[i : i + 3] for i in range(1, len(values), 3)]
        stored = numbers(data.with_suffix(".orth"))
        found = fit(points, numbers(data.with_suffix(".fit")))
        digits = min(
            -mp.log10(abs(f - s) / abs(s)) if f != s else mp.mpf(99) for f, s in zip(found, stored)
        )
        print(f"{data.stem}: {len(points)} points, {mp.nstr(digits, 3)} digits")
        assert digits > 18, data


if __name__ == "__main__":
    main()
