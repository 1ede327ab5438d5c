"""The exact results behind the examples of JCGM 101:2008 clause 9, by quadrature (numpy, scipy).

Prints estimate, standard uncertainty and the ends of the coverage intervals that the tests compare
the Monte Carlo with; the published figures carry Monte Carlo scatter of their own.
"""

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.special import gamma, j0, kv, ndtr

NODES, WEIGHTS = np.polynomial.legendre.leggauss(200)


def rule(low, high, points=None):
    """Gauss-Legendre nodes and weights on [low, high]."""
    nodes, weights = (NODES, WEIGHTS) if points is None else np.polynomial.legendre.leggauss(points)
    return low + (high - low) * (nodes + 1) / 2, (high - low) / 2 * weights


def shortest_scatter(quantile, a, p):
    """Standard deviation of the ends of the shortest interval times M^(1/3). With f the density at
    both ends, the length of the empirical interval h off the best one is a Wiener process of
    variance 2 h / (f^2 M) on the parabola L'' h^2 / 2: Chernoff's distribution, variance 0.2636."""
    d = 1e-4
    length = lambda h: quantile(a + p + h) - quantile(a + h)
    curvature = (length(d) - 2 * length(0) + length(-d)) / d**2
    f = 2 * d / (quantile(a + d) - quantile(a - d))
    return np.sqrt(0.2636) * (np.sqrt(2) / f / (curvature / 2)) ** (2 / 3) / f


def report(name, mean, u, cdf, low, high, p, shortest=False):
    """Prints the symmetric interval and, on request, the shortest; cdf rises from low to high."""
    quantile = lambda a: brentq(lambda y: cdf(y) - a, low, high, xtol=1e-13 * (high - low), rtol=1e-14)
    ends = [quantile((1 - p) / 2), quantile((1 + p) / 2)]
    print(f"{name}: mean {mean:.10g} u {u:.10g} symmetric {ends[0]:.8g} {ends[1]:.8g}", end="")
    if shortest:
        length = lambda a: quantile(a + p) - (quantile(a) if a > 0 else low)
        best = minimize_scalar(length, bounds=(0, 1 - p - 1e-9), method="bounded", options={"xatol": 1e-9})
        inside = best.fun < length(0)
        a = best.x if inside else 0
        print(f" shortest {quantile(a) if inside else low:.8g} {quantile(a + p):.8g}", end="")
        if inside:
            print(f" +- {shortest_scatter(quantile, a, p):.3g} M^(-1/3)", end="")
    print()


def additive_rectangular():
    """9.2.4: three rectangular inputs of standard deviation 1 and one of 10."""
    w = np.sqrt(3) * np.array([1, 1, 1, 10])
    grid = np.array(np.meshgrid(*[[-1, 1]] * 4)).reshape(4, -1)
    shift, sign = grid.T @ w, np.prod(grid, axis=0)
    cdf = lambda y: np.sum(sign * np.maximum(y + shift, 0) ** 4) / (24 * np.prod(2 * w))
    report("9.2.4", 0, np.sqrt(103), cdf, -22, 22, 0.95)


def mass_calibration():
    """9.3: given the three densities the result is Gaussian."""
    m, s = 100001.234, np.hypot(0.05, 0.02)
    a, wa = rule(1.1, 1.3, 40)
    w, ww = rule(7000, 9000, 40)
    r, wr = rule(7950, 8050, 40)
    b = 1 + (a[:, None, None] - 1.2) * (1 / w[None, :, None] - 1 / r[None, None, :])
    weight = wa[:, None, None] * ww[None, :, None] * wr[None, None, :] / (0.2 * 2000 * 100)
    mean = np.sum(weight * m * (b - 1)) + 1.234
    var = np.sum(weight * (m * (b - 1) + 1.234 - mean) ** 2) + np.sum(weight * (s * b) ** 2)
    cdf = lambda y: np.sum(weight * ndtr((y - 1.234 - m * (b - 1)) / (s * b)))
    report("9.3 (mg)", mean, np.sqrt(var), cdf, 0.7, 1.8, 0.95, shortest=True)


def comparison_loss(x1, r):
    """9.4: Y = X1^2 + X2^2, times 1e6; X2 given X1 is Gaussian."""
    s = 0.005

    def cdf(y):
        if y <= 0:
            return 0.0
        t, w = rule(-np.pi / 2, np.pi / 2)
        radius = np.sqrt(y * 1e-6)
        x, half = radius * np.sin(t), radius * np.cos(t)
        centre, spread = r * (x - x1), s * np.sqrt(1 - r * r)
        inside = ndtr((half - centre) / spread) - ndtr((-half - centre) / spread)
        density = np.exp(-(((x - x1) / s) ** 2) / 2) / (s * np.sqrt(2 * np.pi))
        return np.sum(w * half * density * inside)

    mean = x1**2 + 2 * s**2
    var = 4 * s**2 * x1**2 + 4 * s**4 * (1 + r * r)
    report(f"9.4 (1e-6) x1 {x1} r {r}", 1e6 * mean, 1e6 * np.sqrt(var), cdf, 0, 1e6 * (x1 + 12 * s) ** 2, 0.95, True)


def gauge_block():
    """9.5: inversion of the characteristic function. L_s is its estimate in the two products: what
    that leaves out, 25 nm times 5e-7, is 1e-5 nm."""
    length = 50000623.0
    t, wt = rule(1e-9, 0.6, 2000)

    def student(nu, scale):
        z = np.sqrt(nu) * scale * t
        bessel = kv(nu / 2, np.maximum(z, 1e-3)) * z ** (nu / 2) / (gamma(nu / 2) * 2 ** (nu / 2 - 1))
        return np.where(z < 1e-3, 1 - z * z / (2 * nu - 4), bessel)

    def curvilinear(w, d):
        """Nodes and weights of the half-width of CTrap: rectangular on w - d to w + d."""
        v, weight = rule(w - d, w + d, 40)
        return v, weight / (2 * d)

    # delta_alpha (theta_0 + Delta): given delta_alpha, Gaussian plus arc sine.
    product = np.zeros_like(t, dtype=complex)
    for v, weight in zip(*curvilinear(1e-6, 1e-7)):
        a, wa = rule(-v, v, 200)
        q = t[:, None] * length * a[None, :]
        inner = np.exp(0.1j * q - (0.2 * q) ** 2 / 2) * j0(0.5 * q)
        product += weight * (inner @ wa) / (2 * v)
    # alpha_s delta_theta: given alpha_s and the half-width, rectangular.
    expansion = np.zeros_like(t)
    alpha, walpha = rule(9.5e-6, 13.5e-6, 60)
    for v, weight in zip(*curvilinear(0.05, 0.025)):
        expansion += weight * np.sinc(t[:, None] * length * alpha * v / np.pi) @ walpha / 4e-6
    phi = student(18, 25) * student(24, 6) * student(5, 4) * student(8, 7) * product * expansion
    cdf = lambda y: 0.5 - np.sum(wt * np.imag(np.exp(-1j * t * (y - 838)) * phi) / t) / np.pi
    assert abs(phi[-1]) < 1e-20 and abs(phi[0] - 1) < 1e-6

    da2, w2 = 4e-12 / 12 + 1e-14 / 9, 0.01 + 0.04 + 0.125
    as2, dt2 = 11.5e-6**2 + 16e-12 / 12, 0.01 / 12 + 0.025**2 / 9
    student_var = 625 * 18 / 16 + 36 * 24 / 22 + 16 * 5 / 3 + 49 * 8 / 6
    var = student_var + length**2 * (da2 * w2 + as2 * dt2)
    report("9.5 (nm)", 838, np.sqrt(var), cdf, 400, 1276, 0.99, shortest=True)
    print("   first order u", np.sqrt(625 + 36 + 16 + 49 + length**2 * (da2 * 0.01 + 11.5e-6**2 * dt2)))


additive_rectangular()
mass_calibration()
for x1, r in [(x, r) for r in (0, 0.9) for x in (0, 0.01, 0.05)]:
    comparison_loss(x1, r)
gauge_block()
