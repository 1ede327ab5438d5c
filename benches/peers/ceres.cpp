// Ceres on one problem: see problem.rs beside this file for the folders, `run` for the calls.
//
//   ceres-peer PROBLEM ceres|ceres-pairs|ceres-one-block TIMES
//
// prints the seconds of each solve and leaves NAME.solution in the folder of the problem.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <ceres/ceres.h>

namespace {

using Rows = std::vector<std::vector<double>>;

constexpr double kTolerance = 1e-10;
// So loose that steps are those of Gauss-Newton; with 1e16 its damping no longer hides the free
// datum from the Cholesky factorisation, and with 1e6 it costs iterations.
constexpr double kTrustRegion = 1e10;

Rows Read(const std::string& path) {
  std::ifstream file(path);
  if (!file) {
    std::fprintf(stderr, "cannot read %s\n", path.c_str());
    std::exit(1);
  }
  Rows rows;
  for (std::string line; std::getline(file, line);) {
    std::vector<double> row;
    const char* next = line.c_str();
    for (char* end; *next != '\0'; next = *end == ',' ? end + 1 : end) {
      row.push_back(std::strtod(next, &end));
    }
    rows.push_back(row);
  }
  return rows;
}

// |p - S| - L minus the measured length.
class Length final : public ceres::SizedCostFunction<1, 3, 4> {
 public:
  explicit Length(const double* length_mm) : length_mm_(length_mm) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const double* p = parameters[0];
    const double* s = parameters[1];
    const double d[3] = {p[0] - s[0], p[1] - s[1], p[2] - s[2]};
    const double distance = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    residuals[0] = distance - s[3] - *length_mm_;
    if (jacobians == nullptr) return true;
    for (int i = 0; i < 3; ++i) {
      const double u = d[i] / distance;
      if (jacobians[0] != nullptr) jacobians[0][i] = u;
      if (jacobians[1] != nullptr) jacobians[1][i] = -u;
    }
    if (jacobians[1] != nullptr) jacobians[1][3] = -1.0;
    return true;
  }

 private:
  const double* length_mm_;
};

// Some lengths to one point: the stations are one parameter block.
class LengthsToPoint final : public ceres::CostFunction {
 public:
  LengthsToPoint(std::vector<int> stations, std::vector<const double*> lengths_mm, int all_stations)
      : stations_(std::move(stations)),
        lengths_mm_(std::move(lengths_mm)),
        columns_(4 * all_stations) {
    set_num_residuals(static_cast<int>(stations_.size()));
    *mutable_parameter_block_sizes() = {3, columns_};
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const double* p = parameters[0];
    double* of_point = jacobians == nullptr ? nullptr : jacobians[0];
    double* of_stations = jacobians == nullptr ? nullptr : jacobians[1];
    if (of_stations != nullptr) std::fill_n(of_stations, stations_.size() * columns_, 0.0);
    for (size_t row = 0; row < stations_.size(); ++row) {
      const int first = 4 * stations_[row];
      const double* s = parameters[1] + first;
      const double d[3] = {p[0] - s[0], p[1] - s[1], p[2] - s[2]};
      const double distance = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
      residuals[row] = distance - s[3] - *lengths_mm_[row];
      for (int i = 0; i < 3; ++i) {
        const double u = d[i] / distance;
        if (of_point != nullptr) of_point[3 * row + i] = u;
        if (of_stations != nullptr) of_stations[row * columns_ + first + i] = -u;
      }
      if (of_stations != nullptr) of_stations[row * columns_ + first + 3] = -1.0;
    }
    return true;
  }

 private:
  std::vector<int> stations_;
  std::vector<const double*> lengths_mm_;
  int columns_;
};

struct Data {
  int points, stations;
  // x y z of each point, x y z L of each station.
  std::vector<double> start_points, start_stations;
  std::vector<int> station, point;
  std::vector<double> length_mm;
  Rows trials;

  explicit Data(const std::string& folder) : trials(Read(folder + "/trials.csv")) {
    const Rows of_points = Read(folder + "/points.csv");
    const Rows of_stations = Read(folder + "/stations.csv");
    points = static_cast<int>(of_points.size());
    stations = static_cast<int>(of_stations.size());
    for (const auto& p : of_points) start_points.insert(start_points.end(), p.begin(), p.end());
    for (const auto& s : of_stations) {
      start_stations.insert(start_stations.end(), s.begin(), s.end());
    }
    for (const auto& row : Read(folder + "/lengths.csv")) {
      station.push_back(static_cast<int>(row[0]));
      point.push_back(static_cast<int>(row[1]));
      length_mm.push_back(row[2]);
    }
  }
};

// The unknowns, and the lengths that they are sought for.
struct State {
  std::vector<double> points, stations, length_mm;
};

// A residual block for each length, and a parameter block for each station.
void AddLengths(const Data& data, State& state, ceres::Problem& problem,
                ceres::ParameterBlockOrdering& ordering) {
  for (size_t i = 0; i < data.length_mm.size(); ++i) {
    problem.AddResidualBlock(new Length(&state.length_mm[i]), nullptr,
                             &state.points[3 * data.point[i]],
                             &state.stations[4 * data.station[i]]);
  }
  for (int j = 0; j < data.stations; ++j) {
    ordering.AddElementToGroup(&state.stations[4 * j], 1);
  }
}

// One parameter block for all stations, and residual blocks of so many lengths to a point (or fewer): with two,
// Ceres has an elimination that is compiled for this size.
void AddPoints(const Data& data, size_t lengths_in_block, State& state, ceres::Problem& problem,
               ceres::ParameterBlockOrdering& ordering) {
  std::vector<std::vector<int>> stations(data.points);
  std::vector<std::vector<const double*>> lengths(data.points);
  for (size_t i = 0; i < data.length_mm.size(); ++i) {
    stations[data.point[i]].push_back(data.station[i]);
    lengths[data.point[i]].push_back(&state.length_mm[i]);
  }
  for (int i = 0; i < data.points; ++i) {
    for (size_t first = 0; first < stations[i].size(); first += lengths_in_block) {
      const size_t last = std::min(first + lengths_in_block, stations[i].size());
      problem.AddResidualBlock(
          new LengthsToPoint({stations[i].begin() + first, stations[i].begin() + last},
                             {lengths[i].begin() + first, lengths[i].begin() + last},
                             data.stations),
          nullptr, &state.points[3 * i], state.stations.data());
    }
  }
  ordering.AddElementToGroup(state.stations.data(), 1);
}

void WriteRows(std::FILE* file, const std::vector<double>& values, size_t columns) {
  for (size_t i = 0; i < values.size(); ++i) {
    std::fprintf(file, "%.17g%c", values[i], (i + 1) % columns == 0 ? '\n' : ',');
  }
}

}  // namespace

int main(int count, char** words) {
  if (count != 4) {
    std::fprintf(stderr, "usage: ceres-peer PROBLEM ceres|ceres-pairs|ceres-one-block TIMES\n");
    return 2;
  }
  const std::string folder = words[1], name = words[2];
  const Data data(folder);

  // The graph is set up once; its unknowns start anew for every solve.
  State state{data.start_points, data.start_stations, data.length_mm};
  ceres::Problem problem;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (int i = 0; i < data.points; ++i) ordering->AddElementToGroup(&state.points[3 * i], 0);
  if (name == "ceres") {
    AddLengths(data, state, problem, *ordering);
  } else {
    AddPoints(data, name == "ceres-pairs" ? 2 : data.stations, state, problem, *ordering);
  }

  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering = ordering;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.function_tolerance = kTolerance;
  options.gradient_tolerance = kTolerance;
  options.parameter_tolerance = kTolerance;
  options.initial_trust_region_radius = kTrustRegion;

  // One after the other from the same start; each trial once.
  const size_t solves = data.trials.empty() ? std::atoi(words[3]) : data.trials.size();
  for (size_t solve = 0; solve < solves; ++solve) {
    state.points = data.start_points;
    state.stations = data.start_stations;
    for (size_t i = 0; i < data.length_mm.size() && !data.trials.empty(); ++i) {
      state.length_mm[i] = data.length_mm[i] + data.trials[solve][i];
    }
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (summary.termination_type != ceres::CONVERGENCE) {
      std::fprintf(stderr, "not converged: %s\n", summary.message.c_str());
      return 1;
    }
    // Without the preprocessor, which belongs to setting up the graph.
    std::printf("%.9f\n", summary.minimizer_time_in_seconds);
  }

  std::FILE* file = std::fopen((folder + "/" + name + ".solution").c_str(), "w");
  if (file == nullptr) return 1;
  WriteRows(file, state.points, 3);
  WriteRows(file, state.stations, 4);
  return std::fclose(file);
}
