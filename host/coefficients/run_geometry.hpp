// SPDX-License-Identifier: Apache-2.0
// What turns coefficients into heights: the model's lengths and where the pattern lies.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "drivers/support/problem.hpp"
#include "dsp/optics/surface_model.hpp"
#include "host/coefficients/model_file.hpp"
#include "host/coefficients/row_reader.hpp"

namespace CLI {
class App;
}

namespace srd::host {

// From the command line; each given value goes before the model file's.
struct GeometryOptions {
  std::optional<std::filesystem::path> model;   // not given: the one beside the CSV file, if any
  std::optional<std::filesystem::path> points;  // the pattern's corners
  std::optional<double> lx, ly, x0, y0;         // mm
};

struct RunGeometry {
  dsp::SurfaceModel<double> model;
  std::optional<double> refractive_index;
  Plates plates{};
  std::optional<ErrorSources> systematic{};
  PatternExtent pattern;
  std::vector<dsp::Vec2<double>> corners;  // X, Y in mm; empty when only the extent is known
  // Where surfaces are compared: the corners, or an even grid of 21 x 21 over the extent.
  std::vector<dsp::Vec2<double>> places;
};

// --model, --points, --lx, --ly, --x0, --y0.
void add_geometry_options(CLI::App& command, GeometryOptions& options);

// nullopt when neither model file nor options say anything. kUsage when they contradict the run or are
// incomplete.
[[nodiscard]] Outcome<std::optional<RunGeometry>> resolve_geometry(const CoefficientRun& run, const GeometryOptions& options);

// Heights (mm) of any surface of one model at fixed places; the modes are evaluated once.
class SurfaceSampler {
 public:
  SurfaceSampler(const dsp::SurfaceModel<double>& model, const std::vector<dsp::Vec2<double>>& places);
  [[nodiscard]] Eigen::VectorXd heights(const dsp::Coefficients<double>& a) const { return basis_ * a; }

 private:
  Eigen::MatrixXd basis_;  // places x modes
};

}  // namespace srd::host
