// Ceres on one problem: see `run` for the calls, README.md for the layouts.
//
//   ceres-peer FOLDER free|joint LAYOUT TIMES
//
// prints the iterations and the seconds of each solve in one line and leaves MODEL.LAYOUT.solution.

#include <ceres/ceres.h>

#include <algorithm>
#include <memory>

#include "problem.h"

namespace {

// So loose that steps are those of Gauss-Newton; with 1e16 its damping no longer hides the free
// datum from the Cholesky factorisation, and with 1e6 it costs iterations.
constexpr double kTrustRegion = 1e10;

double Dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vec3 Cross(const double* a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// Distance of a point from a station, and the unit vector to it.
double Beam(const double* p, const double* s, double* u) {
  const double d[3] = {p[0] - s[0], p[1] - s[1], p[2] - s[2]};
  const double distance = std::sqrt(Dot(d, d)), inverse = 1 / distance;
  for (int i = 0; i < 3; ++i) u[i] = d[i] * inverse;
  return distance;
}

// The points of a step; in a joint model also the turned arms and directions of deformations, and the left
// Jacobian of the rotation.
struct Placed {
  double p[3][3], turned[3][3], bent[2][3], left[3][3];
};

struct State {
  const Measured& measured;
  bool joint;
  int stations;
  Vec3 arms[kTargets];                // from the centroid
  std::array<Vec3, 2> directions;     // of deformations
  std::vector<double> blocks;         // of every step: points, or centroid and rotation vector
  std::vector<double> shared;         // x y z L of every station, three deformations
  std::vector<double> whitening;      // of every visit: lower triangle of the inverse Cholesky factor

  int BlockSize() const { return joint ? 6 : 9; }

  void Start() {
    const Vec3 c = measured.Centroid();
    for (size_t step = 0; step < measured.steps.size(); ++step) {
      double* block = &blocks[BlockSize() * step];
      for (int i = 0; i < BlockSize(); ++i) {
        block[i] = joint ? (i < 3 ? c[i] + measured.steps[step][i] : 0.0)
                         : measured.home[i / 3][i % 3] + measured.steps[step][i % 3];
      }
    }
    for (int i = 0; i < 4 * stations; ++i) shared[i] = measured.stations[i / 4][i % 4];
    std::fill_n(&shared[4 * stations], 3, 0.0);
    Whiten();
  }

  void Place(const double* block, const double* shape, Placed& placed) const {
    if (!joint) {
      std::copy_n(block, 9, &placed.p[0][0]);
      return;
    }
    const double* w = block + 3;
    // Rotations of a linear axis are small: series to the last bit.
    const double q = Dot(w, w);
    const double a = 1 - q / 6 * (1 - q / 20), b = 0.5 - q / 24 * (1 - q / 30),
                 c = 1.0 / 6 - q / 120 * (1 - q / 42);
    const double x[3][3] = {{0, -w[2], w[1]}, {w[2], 0, -w[0]}, {-w[1], w[0], 0}};
    double r[3][3];
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const double square = w[i] * w[j] - (i == j ? q : 0.0);
        r[i][j] = (i == j) + a * x[i][j] + b * square;
        placed.left[i][j] = (i == j) + b * x[i][j] + c * square;
      }
    }
    for (int i = 0; i < 3; ++i) {
      for (int m = 0; m < 2; ++m) placed.bent[m][i] = Dot(r[i], directions[m].data());
      for (int k = 0; k < 3; ++k) placed.turned[k][i] = Dot(r[i], arms[k].data());
      placed.turned[1][i] += shape[0] * placed.bent[0][i];
      placed.turned[2][i] += shape[1] * placed.bent[0][i] + shape[2] * placed.bent[1][i];
      for (int k = 0; k < 3; ++k) placed.p[k][i] = block[i] + placed.turned[k][i];
    }
  }

  // Anew from the beams at the current values.
  void Whiten() {
    const double length = measured.length_sigma_mm * measured.length_sigma_mm;
    const double machine = measured.repeatability_mm * measured.repeatability_mm;
    Placed placed;
    for (size_t step = 0; step < measured.steps.size(); ++step) {
      Place(&blocks[BlockSize() * step], &shared[4 * stations], placed);
      for (int j = 0; j < stations; ++j) {
        double u[3][3];
        for (int k = 0; k < 3; ++k) Beam(placed.p[k], &shared[4 * j], u[k]);
        const double l00 = std::sqrt(length + machine);
        const double l10 = machine * Dot(u[1], u[0]) / l00, l20 = machine * Dot(u[2], u[0]) / l00;
        const double l11 = std::sqrt(length + machine - l10 * l10);
        const double l21 = (machine * Dot(u[2], u[1]) - l20 * l10) / l11;
        const double l22 = std::sqrt(length + machine - l20 * l20 - l21 * l21);
        double* w = &whitening[6 * (step * stations + j)];
        w[0] = 1 / l00;
        w[2] = 1 / l11;
        w[5] = 1 / l22;
        w[1] = -l10 * w[0] * w[2];
        w[4] = -l21 * w[2] * w[5];
        w[3] = -(l20 * w[0] + l21 * w[1]) * w[5];
      }
    }
  }
};

// The whitened lengths of some visits to a step; all stations are one parameter block with the shape, or each
// is one.
template <bool kJoint, int kVisits>
class Visits final : public ceres::CostFunction {
 public:
  Visits(const State& state, size_t step, int first, bool one_block)
      : state_(state), step_(step), first_(first), one_block_(one_block) {
    set_num_residuals(3 * kVisits);
    auto* sizes = mutable_parameter_block_sizes();
    *sizes = {kBlock};
    if (one_block) {
      sizes->push_back(4 * state.stations + (kJoint ? 3 : 0));
    } else {
      sizes->insert(sizes->end(), kVisits, 4);
      if (kJoint) sizes->push_back(3);
    }
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    // Where the shape is, and how long the rows of shape and stations are.
    const int at_shape = one_block_ ? 1 : 1 + kVisits, shape_column = one_block_ ? 4 * state_.stations : 0;
    const int shape_width = shape_column + 3;
    const int station_width = one_block_ ? parameter_block_sizes()[1] : 4;
    Placed placed;
    state_.Place(parameters[0], kJoint ? parameters[at_shape] + shape_column : nullptr, placed);
    for (int i = 1; jacobians != nullptr && i < static_cast<int>(parameter_block_sizes().size()); ++i) {
      if (jacobians[i] != nullptr) std::fill_n(jacobians[i], 3 * kVisits * parameter_block_sizes()[i], 0.0);
    }
    for (int i = 0; i < kVisits; ++i) {
      const int j = first_ + i;
      const size_t visit = step_ * state_.stations + j;
      const double* s = one_block_ ? parameters[1] + 4 * j : parameters[1 + i];
      double* of_station = jacobians == nullptr ? nullptr : jacobians[one_block_ ? 1 : 1 + i];
      double* of_shape = kJoint && jacobians != nullptr ? jacobians[at_shape] : nullptr;
      const double* w = &state_.whitening[6 * visit];
      double u[3][3], r[3], of_block[3][kBlock] = {}, bent[3][3] = {};
      for (int k = 0; k < 3; ++k) {
        r[k] = Beam(placed.p[k], s, u[k]) - s[3] - state_.measured.lengths[visit][k];
        if (jacobians == nullptr) continue;
        if constexpr (kJoint) {
          const Vec3 turn = Cross(placed.turned[k], {u[k][0], u[k][1], u[k][2]});
          for (int c = 0; c < 3; ++c) {
            of_block[k][c] = u[k][c];
            of_block[k][3 + c] =
                turn[0] * placed.left[0][c] + turn[1] * placed.left[1][c] + turn[2] * placed.left[2][c];
          }
          if (k == 1) bent[1][0] = Dot(u[1], placed.bent[0]);
          if (k == 2) bent[2][1] = Dot(u[2], placed.bent[0]), bent[2][2] = Dot(u[2], placed.bent[1]);
        } else {
          std::copy_n(u[k], 3, of_block[k] + 3 * k);
        }
      }
      for (int k = 0; k < 3; ++k, w += k) {
        const int row = 3 * i + k;
        residuals[row] = 0;
        for (int t = 0; t <= k; ++t) residuals[row] += w[t] * r[t];
        if (jacobians != nullptr && jacobians[0] != nullptr) {
          Add(w, k, of_block, 1.0, jacobians[0] + kBlock * row, true);
        }
        if (of_station != nullptr) {
          double* at = of_station + station_width * row + (one_block_ ? 4 * j : 0);
          Add(w, k, u, -1.0, at, false);
          for (int t = 0; t <= k; ++t) at[3] -= w[t];
        }
        if (of_shape != nullptr) Add(w, k, bent, 1.0, of_shape + shape_width * row + shape_column, false);
      }
    }
    return true;
  }

 private:
  static constexpr int kBlock = kJoint ? 6 : 9;

  // Row k of the whitened rows.
  template <int n>
  static void Add(const double* w, int k, const double (&rows)[3][n], double sign, double* to, bool anew) {
    for (int c = 0; c < n; ++c) {
      double sum = anew ? 0 : to[c];
      for (int t = 0; t <= k; ++t) sum += sign * w[t] * rows[t][c];
      to[c] = sum;
    }
  }

  const State& state_;
  size_t step_;
  int first_;
  bool one_block_;
};

// Whitens wherever derivatives are taken.
class Anew final : public ceres::EvaluationCallback {
 public:
  explicit Anew(State& state) : state_(state) {}
  void PrepareForEvaluation(bool jacobians, bool) override {
    if (jacobians) state_.Whiten();
  }

 private:
  State& state_;
};

template <bool kJoint, int kVisits>
void Add(State& state, bool one_block, ceres::Problem& problem) {
  for (size_t step = 0; step < state.measured.steps.size(); ++step) {
    for (int first = 0; first < state.stations; first += kVisits) {
      std::vector<double*> blocks{&state.blocks[state.BlockSize() * step]};
      if (one_block) {
        blocks.push_back(state.shared.data());
      } else {
        for (int j = first; j < first + kVisits; ++j) blocks.push_back(&state.shared[4 * j]);
        if (kJoint) blocks.push_back(&state.shared[4 * state.stations]);
      }
      problem.AddResidualBlock(new Visits<kJoint, kVisits>(state, step, first, one_block), nullptr, blocks);
    }
  }
}

template <bool kJoint>
void Add(State& state, int visits, bool one_block, ceres::Problem& problem) {
  if (visits == 1) return Add<kJoint, 1>(state, one_block, problem);
  if (visits == 4) return Add<kJoint, 4>(state, one_block, problem);
  Add<kJoint, 8>(state, one_block, problem);
}

}  // namespace

int main(int count, char** words) {
  if (count != 5) {
    std::fprintf(stderr, "usage: ceres-peer FOLDER free|joint LAYOUT TIMES\n");
    return 2;
  }
  const std::string folder = words[1], model = words[2], layout = words[3];
  const auto says = [&](const char* word) { return layout.find(word) != std::string::npos; };
  const Measured measured(folder);

  State state{measured, model == "joint", static_cast<int>(measured.stations.size())};
  const Vec3 c = measured.Centroid();
  for (int k = 0; k < kTargets; ++k) {
    for (int i = 0; i < 3; ++i) state.arms[k][i] = measured.home[k][i] - c[i];
  }
  state.directions = measured.ShapeDirections();
  state.blocks.resize(state.BlockSize() * measured.steps.size());
  state.shared.resize(4 * state.stations + 3);
  state.whitening.resize(6 * measured.lengths.size());

  // The graph is set up once; its unknowns start anew for every solve.
  Anew anew(state);
  ceres::Problem::Options problem_options;
  if (says("anew")) problem_options.evaluation_callback = &anew;
  ceres::Problem problem(problem_options);
  const bool one_block = says("shared");
  const int visits = says("visit") ? 1 : state.stations;
  state.joint ? Add<true>(state, visits, one_block, problem) : Add<false>(state, visits, one_block, problem);
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (size_t i = 0; i < state.blocks.size(); i += state.BlockSize()) {
    ordering->AddElementToGroup(&state.blocks[i], 0);
  }
  if (one_block) {
    ordering->AddElementToGroup(state.shared.data(), 1);
  } else {
    for (int j = 0; j < state.stations; ++j) ordering->AddElementToGroup(&state.shared[4 * j], 1);
    if (state.joint) ordering->AddElementToGroup(&state.shared[4 * state.stations], 1);
  }

  const double tolerance = says("anew") ? 1e-11 : 1e-8;
  ceres::Solver::Options options;
  options.linear_solver_type = says("sparse") ? ceres::SPARSE_SCHUR : ceres::DENSE_SCHUR;
  options.linear_solver_ordering = ordering;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.function_tolerance = tolerance;
  options.gradient_tolerance = tolerance;
  options.parameter_tolerance = tolerance;
  options.initial_trust_region_radius = kTrustRegion;

  std::string seconds;
  int iterations = 0;
  for (int solve = 0; solve < std::atoi(words[4]); ++solve) {
    state.Start();
    double time = 0;
    iterations = 0;
    // From the weights of the start to the minimum, and again from those of this.
    for (int pass = 0; pass < (says("anew") ? 1 : 2); ++pass) {
      if (pass > 0) state.Whiten();
      ceres::Solver::Summary summary;
      ceres::Solve(options, &problem, &summary);
      if (summary.termination_type != ceres::CONVERGENCE) {
        std::fprintf(stderr, "not converged: %s\n", summary.message.c_str());
        return 1;
      }
      // Without the preprocessor, which belongs to setting up the graph.
      time += summary.minimizer_time_in_seconds;
      iterations += static_cast<int>(summary.iterations.size()) - 1;
    }
    seconds += " " + std::to_string(1e6 * time) + "e-6";
  }
  std::printf("%d%s\n", iterations, seconds.c_str());

  std::vector<double> points;
  for (size_t step = 0; step < measured.steps.size(); ++step) {
    Placed placed;
    state.Place(&state.blocks[state.BlockSize() * step], &state.shared[4 * state.stations], placed);
    points.insert(points.end(), &placed.p[0][0], &placed.p[0][0] + 9);
  }
  state.shared.resize(4 * state.stations);
  WriteSolution(folder + "/" + model + "." + layout + ".solution", points, state.shared);
}
