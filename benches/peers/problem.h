// Problems and solutions as files: see trueaxis/files.rs.
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

constexpr int kTargets = 3;

using Vec3 = std::array<double, 3>;

inline std::vector<std::vector<double>> ReadRows(const std::string& path) {
  std::ifstream file(path);
  if (!file) {
    std::fprintf(stderr, "cannot read %s\n", path.c_str());
    std::exit(1);
  }
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(file, line);) {
    std::vector<double> row;
    for (char *next = line.data(), *end; *next != '\0'; next = *end == ',' ? end + 1 : end) {
      row.push_back(std::strtod(next, &end));
    }
    rows.push_back(row);
  }
  return rows;
}

// One visit of every station to every step.
struct Measured {
  double length_sigma_mm, repeatability_mm;
  std::vector<std::array<double, 4>> stations;  // x y z L, start
  Vec3 home[kTargets];                          // targets, nominal
  std::vector<Vec3> steps;                      // how far each step moves them, nominal
  std::vector<Vec3> lengths;                    // of step * stations + station

  explicit Measured(const std::string& folder) {
    const auto noise = ReadRows(folder + "/noise.csv");
    length_sigma_mm = noise[0][0];
    repeatability_mm = noise[0][1];
    for (const auto& s : ReadRows(folder + "/stations.csv")) stations.push_back({s[0], s[1], s[2], s[3]});
    const auto targets = ReadRows(folder + "/targets.csv");
    for (int k = 0; k < kTargets; ++k) home[k] = {targets[k][0], targets[k][1], targets[k][2]};
    for (const auto& s : ReadRows(folder + "/steps.csv")) steps.push_back({s[0], s[1], s[2]});
    lengths.resize(steps.size() * stations.size());
    for (const auto& row : ReadRows(folder + "/lengths.csv")) {
      const size_t station = static_cast<size_t>(row[0]), step = static_cast<size_t>(row[1]);
      lengths[step * stations.size() + station] = {row[2], row[3], row[4]};
    }
  }

  // Directions of two deformations of the triangle in its own plane. With target 1 moving along the first and
  // target 2 along both, every shape is reached once.
  std::array<Vec3, 2> ShapeDirections() const {
    Vec3 first, second;
    double along = 0, of_first = 0, of_second = 0;
    for (int i = 0; i < 3; ++i) {
      first[i] = home[1][i] - home[0][i];
      second[i] = home[2][i] - home[0][i];
      of_first += first[i] * first[i];
    }
    for (int i = 0; i < 3; ++i) along += second[i] * (first[i] /= std::sqrt(of_first));
    for (int i = 0; i < 3; ++i) {
      second[i] -= along * first[i];
      of_second += second[i] * second[i];
    }
    for (double& x : second) x /= std::sqrt(of_second);
    return {first, second};
  }

  Vec3 Centroid() const {
    Vec3 c;
    for (int i = 0; i < 3; ++i) c[i] = (home[0][i] + home[1][i] + home[2][i]) / 3;
    return c;
  }
};

// MODEL.SOLVER.solution: points (x y z) of all steps, then stations (x y z L).
inline void WriteSolution(const std::string& path, const std::vector<double>& points,
                          const std::vector<double>& stations) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) std::exit(1);
  for (size_t i = 0; i < points.size(); i += 3) {
    std::fprintf(file, "%.17g,%.17g,%.17g\n", points[i], points[i + 1], points[i + 2]);
  }
  for (size_t i = 0; i < stations.size(); i += 4) {
    std::fprintf(file, "%.17g,%.17g,%.17g,%.17g\n", stations[i], stations[i + 1], stations[i + 2],
                 stations[i + 3]);
  }
  std::fclose(file);
}
