// The least that the adjustment costs: Gauss-Newton with weights anew in each iteration, several steps side by
// side in the lanes of a register, and nothing else - no checks, no rank tests, no step control.
//
//   kernel FOLDER free|joint kernel TIMES
//
// prints the iterations and the seconds of each solve in one line and leaves MODEL.kernel.solution.

#include <chrono>
#include <memory>

#include "problem.h"

namespace {

#ifdef __AVX512F__
constexpr int kLanes = 8;
#else
constexpr int kLanes = 4;
#endif
#define INLINE __attribute__((always_inline)) inline

// The target that a deformation moves.
constexpr int kTargetOf[3] = {1, 2, 2};

typedef double Lanes __attribute__((vector_size(8 * kLanes)));

// It ends when the next correction of the stations, as the last two predict it, is below this.
constexpr double kNextCorrectionMm = 1e-8;

Lanes All(double x) {
  Lanes all;
  for (int l = 0; l < kLanes; ++l) all[l] = x;
  return all;
}

Lanes Sqrt(Lanes x) {
  for (int l = 0; l < kLanes; ++l) x[l] = std::sqrt(x[l]);
  return x;
}

double Sum(Lanes x) {
  double sum = 0;
  for (int l = 0; l < kLanes; ++l) sum += x[l];
  return sum;
}

// Solves the symmetric positive definite system; a is destroyed.
template <int n>
void SolveDense(double (&a)[n][n], double (&x)[n]) {
  for (int j = 0; j < n; ++j) {
    for (int k = 0; k < j; ++k) {
      for (int i = j; i < n; ++i) a[i][j] -= a[i][k] * a[j][k];
    }
    const double d = 1 / std::sqrt(a[j][j]);
    for (int i = j; i < n; ++i) a[i][j] *= d;
  }
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < i; ++k) x[i] -= a[i][k] * x[k];
    x[i] /= a[i][i];
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int k = i + 1; k < n; ++k) x[i] -= a[k][i] * x[k];
    x[i] /= a[i][i];
  }
}

template <bool kJoint, int kStations>
class Kernel {
  static constexpr int kBlock = kJoint ? 6 : 9;
  static constexpr int kOfStations = 4 * kStations;
  static constexpr int kShared = kOfStations + (kJoint ? 3 : 0);
  // Behind the shared unknowns the right-hand side.
  static constexpr int kColumns = kShared + 1;

  // Some steps side by side.
  struct Steps {
    Lanes weight;  // 1, and next to 0 where there is no step
    Lanes length[kStations][3];
    Lanes place[kJoint ? 12 : 9];  // points; or the turned centroid and the rotation
  };
  // Cholesky factor of their own normal equations: lower triangle, row by row, with reciprocals on the diagonal.
  using Factor = std::array<Lanes, kBlock*(kBlock + 1) / 2>;
  // One visit: beams, weighted residuals, inverse covariance; and for every target its row of the inverse times
  // the derivatives by the point and the dead path.
  struct Visit {
    Lanes u[3][3], r[3], w[3][3], g[3][4];
  };
  // Derivatives of the lengths of a visit by the unknowns of its step and by the deformations 0 (of target 1),
  // 1 and 2 (of target 2).
  struct Pose {
    Lanes of[3][6], of_shape[3];
  };

 public:
  explicit Kernel(const Measured& measured)
      : measured_(measured), directions_(measured.ShapeDirections()), centroid_(measured.Centroid()) {
    const size_t count = (measured.steps.size() + kLanes - 1) / kLanes;
    start_.resize(count);
    factors_.resize(count);
    for (size_t i = 0; i < count * kLanes; ++i) {
      const size_t step = std::min(i, measured.steps.size() - 1);
      Steps& steps = start_[i / kLanes];
      const int l = i % kLanes;
      steps.weight[l] = i == step ? 1 : 1e-30;
      for (int j = 0; j < kStations; ++j) {
        for (int k = 0; k < 3; ++k) steps.length[j][k][l] = measured.lengths[step * kStations + j][k];
      }
      for (int c = 0; c < 3; ++c) {
        if constexpr (kJoint) {
          steps.place[c][l] = centroid_[c] + measured.steps[step][c];
          for (int d = 0; d < 3; ++d) steps.place[3 + 3 * c + d][l] = c == d;
        } else {
          for (int k = 0; k < 3; ++k) steps.place[3 * k + c][l] = measured.home[k][c] + measured.steps[step][c];
        }
      }
    }
    steps_ = start_;
  }

  int Solve() {
    steps_ = start_;
    for (int i = 0; i < kOfStations; ++i) shared_[i] = measured_.stations[i / 4][i % 4];
    for (int i = kOfStations; i < kShared; ++i) shared_[i] = 0;
    double last = 1;
    for (int iteration = 1;; ++iteration) {
      Eliminate();
      SolveShared();
      for (size_t i = 0; i < steps_.size(); ++i) Correct(steps_[i], factors_[i]);
      double moved = 0;
      for (int i = 0; i < kShared; ++i) {
        shared_[i] += correction_[i];
        moved = std::max(moved, std::fabs(correction_[i]));
      }
      if (moved * std::min(1.0, moved / last) < kNextCorrectionMm || iteration == 20) return iteration;
      last = moved;
    }
  }

  void Write(const std::string& path) {
    std::vector<double> points;
    for (size_t i = 0; i < measured_.steps.size(); ++i) {
      Lanes arms[3][3], p[3][3], along[2][3];
      Place(steps_[i / kLanes], arms, along, p);
      for (int k = 0; k < 9; ++k) points.push_back(p[k / 3][k % 3][i % kLanes]);
    }
    WriteSolution(path, points, {shared_, shared_ + kOfStations});
  }

 private:
  // Turned arms and directions of deformations, and points.
  INLINE void Place(const Steps& steps, Lanes (&arms)[3][3], Lanes (&along)[2][3], Lanes (&p)[3][3]) const {
    for (int k = 0; k < 3; ++k) {
      if constexpr (kJoint) {
        double arm[3];
        for (int c = 0; c < 3; ++c) {
          const double* s = shared_ + kOfStations;
          arm[c] = measured_.home[k][c] - centroid_[c] + (k == 1 ? s[0] * directions_[0][c] : 0) +
                   (k == 2 ? s[1] * directions_[0][c] + s[2] * directions_[1][c] : 0);
        }
        for (int c = 0; c < 3; ++c) {
          const Lanes* r = steps.place + 3 + 3 * c;
          arms[k][c] = r[0] * arm[0] + r[1] * arm[1] + r[2] * arm[2];
          p[k][c] = steps.place[c] + arms[k][c];
          if (k < 2) along[k][c] = r[0] * directions_[k][0] + r[1] * directions_[k][1] + r[2] * directions_[k][2];
        }
      } else {
        for (int c = 0; c < 3; ++c) p[k][c] = steps.place[3 * k + c];
      }
    }
  }

  // Normal equations of all, with the unknowns of the steps eliminated.
  void Eliminate() {
    for (auto& row : sums_) {
      for (Lanes& sum : row) sum = All(0);
    }
    for (size_t i = 0; i < steps_.size(); ++i) EliminateSteps(steps_[i], factors_[i]);
  }

  // Everything of a visit to some steps, whose arms and points are given.
  INLINE Visit Look(const Steps& steps, int j, const Lanes (&p)[3][3]) const {
    const double machine = measured_.repeatability_mm * measured_.repeatability_mm;
    const double diagonal = measured_.length_sigma_mm * measured_.length_sigma_mm + machine;
    const double* s = shared_ + 4 * j;
    Visit v;
    for (int k = 0; k < 3; ++k) {
      const Lanes d[3] = {p[k][0] - s[0], p[k][1] - s[1], p[k][2] - s[2]};
      const Lanes distance = Sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), inverse = 1.0 / distance;
      v.r[k] = steps.length[j][k] + s[3] - distance;
      for (int c = 0; c < 3; ++c) v.u[k][c] = d[c] * inverse;
    }
    // Inverse of the covariance of the three lengths, by cofactors.
    const auto covariance = [&](int a, int b) {
      return machine * (v.u[a][0] * v.u[b][0] + v.u[a][1] * v.u[b][1] + v.u[a][2] * v.u[b][2]);
    };
    const Lanes a = covariance(0, 1), b = covariance(0, 2), c = covariance(1, 2);
    const Lanes c00 = diagonal * diagonal - c * c, c01 = b * c - a * diagonal, c02 = a * c - b * diagonal;
    const Lanes scale = steps.weight / (diagonal * c00 + a * c01 + b * c02);
    v.w[0][0] = scale * c00;
    v.w[0][1] = v.w[1][0] = scale * c01;
    v.w[0][2] = v.w[2][0] = scale * c02;
    v.w[1][1] = scale * (diagonal * diagonal - b * b);
    v.w[1][2] = v.w[2][1] = scale * (a * b - c * diagonal);
    v.w[2][2] = scale * (diagonal * diagonal - a * a);
    return v;
  }

  INLINE void Weigh(Visit& v) const {
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 3; ++i) {
        v.g[k][i] = v.w[k][0] * v.u[0][i] + v.w[k][1] * v.u[1][i] + v.w[k][2] * v.u[2][i];
      }
      v.g[k][3] = v.w[k][0] + v.w[k][1] + v.w[k][2];
    }
  }

  INLINE Pose Derive(const Visit& v, const Lanes (&arms)[3][3], const Lanes (&along)[2][3]) const {
    Pose pose;
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 3; ++i) {
        const int m = (i + 1) % 3, q = (i + 2) % 3;
        pose.of[k][i] = v.u[k][i];
        pose.of[k][3 + i] = arms[k][m] * v.u[k][q] - arms[k][q] * v.u[k][m];
      }
    }
    for (int m = 0; m < 3; ++m) {
      const Lanes *a = along[m == 2], *b = v.u[kTargetOf[m]];
      pose.of_shape[m] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    }
    return pose;
  }

  INLINE void EliminateSteps(const Steps& steps, Factor& factor) {
    Lanes n[kBlock][kBlock], e[kBlock][kColumns];
    for (int i = 0; i < kBlock; ++i) {
      for (int j = 0; j <= i; ++j) n[i][j] = All(0);
      for (int j = kOfStations; j < kColumns; ++j) e[i][j] = All(0);
    }
    Lanes arms[3][3], p[3][3], along[2][3];
    Place(steps, arms, along, p);
    for (int j = 0; j < kStations; ++j) {
      Visit v = Look(steps, j, p);
      Weigh(v);
      const auto &u = v.u, &w = v.w;
      const auto& g = v.g;
      Lanes y[3];
      for (int k = 0; k < 3; ++k) y[k] = w[k][0] * v.r[0] + w[k][1] * v.r[1] + w[k][2] * v.r[2];
      // Stations (-u, -1) against themselves.
      for (int i = 0; i < 4; ++i) {
        for (int k = 0; k <= i; ++k) {
          sums_[4 * j + i][4 * j + k] +=
              i < 3 ? g[0][k] * u[0][i] + g[1][k] * u[1][i] + g[2][k] * u[2][i] : g[0][k] + g[1][k] + g[2][k];
        }
        sums_[kShared][4 * j + i] -= i < 3 ? y[0] * u[0][i] + y[1] * u[1][i] + y[2] * u[2][i] : y[0] + y[1] + y[2];
      }
      if constexpr (kJoint) {
        const Pose pose = Derive(v, arms, along);
        for (int i = 0; i < 6; ++i) {
          Lanes weighted[3];
          for (int k = 0; k < 3; ++k) {
            weighted[k] = i < 3 ? g[k][i] : w[k][0] * pose.of[0][i] + w[k][1] * pose.of[1][i] + w[k][2] * pose.of[2][i];
          }
          for (int k = i; k < 6; ++k) {
            n[k][i] += weighted[0] * pose.of[0][k] + weighted[1] * pose.of[1][k] + weighted[2] * pose.of[2][k];
          }
          for (int c = 0; c < 3; ++c) {
            e[i][4 * j + c] = -(weighted[0] * u[0][c] + weighted[1] * u[1][c] + weighted[2] * u[2][c]);
          }
          e[i][4 * j + 3] = -(weighted[0] + weighted[1] + weighted[2]);
          for (int m = 0; m < 3; ++m) e[i][kOfStations + m] += weighted[kTargetOf[m]] * pose.of_shape[m];
          e[i][kShared] += pose.of[0][i] * y[0] + pose.of[1][i] * y[1] + pose.of[2][i] * y[2];
        }
        for (int m = 0; m < 3; ++m) {
          const int row = kOfStations + m, target = kTargetOf[m];
          for (int c = 0; c < 4; ++c) sums_[row][4 * j + c] -= g[target][c] * pose.of_shape[m];
          for (int q = 0; q <= m; ++q) {
            sums_[row][kOfStations + q] += w[target][kTargetOf[q]] * pose.of_shape[m] * pose.of_shape[q];
          }
          sums_[kShared][row] += y[target] * pose.of_shape[m];
        }
      } else {
        for (int k = 0; k < 3; ++k) {
          for (int i = 0; i < 3; ++i) {
            for (int t = 0; t <= k; ++t) {
              const Lanes wu = w[k][t] * u[k][i];
              for (int c = 0; c < (t < k ? 3 : i + 1); ++c) n[3 * k + i][3 * t + c] += wu * u[t][c];
            }
            for (int c = 0; c < 4; ++c) e[3 * k + i][4 * j + c] = -u[k][i] * g[k][c];
            e[3 * k + i][kShared] += u[k][i] * y[k];
          }
        }
      }
    }

    // Cholesky, and its factor taken off all columns.
    for (int j = 0; j < kBlock; ++j) {
      Lanes d = n[j][j];
      for (int k = 0; k < j; ++k) d -= n[j][k] * n[j][k];
      const Lanes inverse = 1.0 / Sqrt(d);
      n[j][j] = inverse;
      for (int i = j + 1; i < kBlock; ++i) {
        Lanes x = n[i][j];
        for (int k = 0; k < j; ++k) x -= n[i][k] * n[j][k];
        n[i][j] = x * inverse;
      }
    }
    for (int i = 0; i < kBlock; ++i) {
      for (int k = 0; k <= i; ++k) factor[i * (i + 1) / 2 + k] = n[i][k];
    }
    for (int c = 0; c < kColumns; ++c) {
      Lanes x[kBlock];
      for (int i = 0; i < kBlock; ++i) {
        x[i] = e[i][c];
        for (int k = 0; k < i; ++k) x[i] -= n[i][k] * x[k];
        x[i] *= n[i][i];
        e[i][c] = x[i];
      }
    }
    // What the steps take off the shared system, in tiles that fit the registers.
    constexpr int kTile = 4;
    for (int i0 = 0; i0 < kColumns; i0 += kTile) {
      for (int j0 = 0; j0 <= i0; j0 += kTile) {
        if (i0 + kTile <= kColumns) {
          Tile<kTile>(e, i0, j0);
        } else {
          Tile<kColumns % kTile>(e, i0, j0);
        }
      }
    }
  }

  // sums -= columnsᵀ columns for some rows and four columns. On the diagonal what lies above it is never read.
  template <int kRows>
  INLINE void Tile(const Lanes (&e)[kBlock][kColumns], int i0, int j0) {
    Lanes sum[kRows > 0 ? kRows : 1][4];
    for (int i = 0; i < kRows; ++i) {
      for (int j = 0; j < 4; ++j) sum[i][j] = sums_[i0 + i][j0 + j];
    }
    for (int k = 0; k < kBlock; ++k) {
      for (int i = 0; i < kRows; ++i) {
        for (int j = 0; j < 4; ++j) sum[i][j] -= e[k][i0 + i] * e[k][std::min(j0 + j, kColumns - 1)];
      }
    }
    for (int i = 0; i < kRows; ++i) {
      for (int j = 0; j < 4; ++j) sums_[i0 + i][j0 + j] = sum[i][j];
    }
  }

  // Motions of the whole are held by adding G Gᵀ to the singular system; its solution stays the same.
  void SolveShared() {
    static double a[kShared][kShared];
    double trace = 0;
    for (int i = 0; i < kShared; ++i) {
      for (int j = 0; j <= i; ++j) a[i][j] = a[j][i] = Sum(sums_[i][j]);
      correction_[i] = Sum(sums_[kShared][i]);
      trace += a[i][i];
    }
    double centre[3] = {};
    for (int i = 0; i < kOfStations; ++i) {
      if (i % 4 < 3) centre[i % 4] += shared_[i] / kStations;
    }
    for (int motion = 0; motion < 6; ++motion) {
      double g[kShared] = {}, norm = 0;
      for (int j = 0; j < kStations; ++j) {
        const int axis = motion % 3, next = (axis + 1) % 3, after = (axis + 2) % 3;
        if (motion < 3) g[4 * j + axis] = 1;
        if (motion >= 3) {
          g[4 * j + next] = -(shared_[4 * j + after] - centre[after]);
          g[4 * j + after] = shared_[4 * j + next] - centre[next];
        }
      }
      for (double x : g) norm += x * x;
      const double factor = trace / kShared / norm;
      for (int i = 0; i < kShared; ++i) {
        for (int j = 0; j < kShared; ++j) a[i][j] += factor * g[i] * g[j];
      }
    }
    SolveDense(a, correction_);
  }

  // x = N⁻¹ Aᵀ W (r - B s): the right side from the beams as they were, before the shared unknowns move.
  INLINE void Correct(Steps& steps, const Factor& factor) {
    Lanes x[kBlock];
    for (Lanes& sum : x) sum = All(0);
    Lanes arms[3][3], p[3][3], along[2][3];
    Place(steps, arms, along, p);
    for (int j = 0; j < kStations; ++j) {
      const Visit v = Look(steps, j, p);
      const double* s = correction_ + 4 * j;
      Lanes left[3];
      for (int k = 0; k < 3; ++k) {
        left[k] = v.r[k] + (v.u[k][0] * s[0] + v.u[k][1] * s[1] + v.u[k][2] * s[2] + s[3]);
      }
      Pose pose;
      if constexpr (kJoint) {
        pose = Derive(v, arms, along);
        for (int m = 0; m < 3; ++m) left[kTargetOf[m]] -= pose.of_shape[m] * correction_[kOfStations + m];
      }
      for (int k = 0; k < 3; ++k) {
        const Lanes y = v.w[k][0] * left[0] + v.w[k][1] * left[1] + v.w[k][2] * left[2];
        if constexpr (kJoint) {
          for (int i = 0; i < 6; ++i) x[i] += pose.of[k][i] * y;
        } else {
          for (int i = 0; i < 3; ++i) x[3 * k + i] += v.u[k][i] * y;
        }
      }
    }
    const auto l = [&](int i, int k) { return factor[i * (i + 1) / 2 + k]; };
    for (int i = 0; i < kBlock; ++i) {
      for (int k = 0; k < i; ++k) x[i] -= l(i, k) * x[k];
      x[i] *= l(i, i);
    }
    for (int i = kBlock - 1; i >= 0; --i) {
      for (int k = i + 1; k < kBlock; ++k) x[i] -= l(k, i) * x[k];
      x[i] *= l(i, i);
    }
    if constexpr (kJoint) {
      for (int c = 0; c < 3; ++c) steps.place[c] += x[c];
      // Rotation by the vector w: series to the last bit for the small angles of corrections.
      const Lanes* w = x + 3;
      const Lanes q = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
      const Lanes a = 1 - q * (1.0 / 6) * (1 - q * 0.05), b = 0.5 - q * (1.0 / 24) * (1 - q * (1.0 / 30));
      for (int d = 0; d < 3; ++d) {
        Lanes* r = steps.place + 3 + d;
        const Lanes v[3] = {r[0], r[3], r[6]};
        const Lanes along = w[0] * v[0] + w[1] * v[1] + w[2] * v[2];
        for (int i = 0; i < 3; ++i) {
          const int j = (i + 1) % 3, k = (i + 2) % 3;
          r[3 * i] = v[i] + a * (w[j] * v[k] - w[k] * v[j]) + b * (along * w[i] - q * v[i]);
        }
      }
    } else {
      for (int i = 0; i < 9; ++i) steps.place[i] += x[i];
    }
  }

  const Measured& measured_;
  const std::array<Vec3, 2> directions_;
  const Vec3 centroid_;
  std::vector<Steps> start_, steps_;
  std::vector<Factor> factors_;
  double shared_[kShared], correction_[kShared];
  Lanes sums_[kColumns][kColumns + 3];
};

template <bool kJoint, int kStations>
void Run(const Measured& measured, int times, const std::string& path) {
  const auto kernel = std::make_unique<Kernel<kJoint, kStations>>(measured);
  std::string seconds;
  int iterations = 0;
  for (int i = 0; i < times; ++i) {
    const auto start = std::chrono::steady_clock::now();
    iterations = kernel->Solve();
    const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - start;
    seconds += " " + std::to_string(time.count()) + "e-6";
  }
  std::printf("%d%s\n", iterations, seconds.c_str());
  kernel->Write(path);
}

}  // namespace

int main(int count, char** words) {
  if (count != 5) {
    std::fprintf(stderr, "usage: kernel FOLDER free|joint kernel TIMES\n");
    return 2;
  }
  const std::string folder = words[1], model = words[2];
  const Measured measured(folder);
  const std::string path = folder + "/" + model + "." + words[3] + ".solution";
  const int times = std::atoi(words[4]);
  const bool joint = model == "joint";
  if (measured.stations.size() == 4) {
    joint ? Run<true, 4>(measured, times, path) : Run<false, 4>(measured, times, path);
  } else {
    joint ? Run<true, 8>(measured, times, path) : Run<false, 8>(measured, times, path);
  }
}
