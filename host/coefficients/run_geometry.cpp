// SPDX-License-Identifier: Apache-2.0
#include "host/coefficients/run_geometry.hpp"

#include <algorithm>
#include <cmath>

#include <CLI/CLI.hpp>

#include "drivers/geometry/points.hpp"
#include "drivers/support/mode_names.hpp"

namespace srd::host {
namespace {

constexpr int kGridSteps = 20;

// The run's node in the model file; nullopt when there is none.
Outcome<std::optional<NodeModel>> from_model_file(const CoefficientRun& run, const GeometryOptions& options) {
  const std::filesystem::path file = options.model.value_or(model_file_path(run.file));
  std::error_code error;
  if (!options.model && !std::filesystem::exists(file, error)) return std::optional<NodeModel>{};
  const auto model_file = read_model_file(file);
  if (!model_file) return model_file.error();
  const NodeModel* node = model_file->find(run.node);
  if (node == nullptr)
    return Problem{Exit::kUsage, "says nothing of node '" + run.node + "'", file.string(), "a [[node]] of that name"};
  if (!(node->model.modes == run.modes))
    return Problem{
        Exit::kUsage,           "has other modes than " + run.file, file.string(),
        joined(run.modes, " "), joined(node->model.modes, " "),     "give the file that was written with the coefficients"};
  return std::optional(*node);
}

std::vector<dsp::Vec2<double>> grid_over(const PatternExtent& e) {
  std::vector<dsp::Vec2<double>> places;
  for (int i = 0; i <= kGridSteps; ++i)
    for (int j = 0; j <= kGridSteps; ++j)
      places.emplace_back(e.x_min + (e.x_max - e.x_min) * i / kGridSteps, e.y_min + (e.y_max - e.y_min) * j / kGridSteps);
  return places;
}

}  // namespace

void add_geometry_options(CLI::App& command, GeometryOptions& options) {
  command.add_option("--model", options.model, "Surface model beside the coefficients (default: FILE.csv.model.toml)");
  command.add_option("--points", options.points, "The pattern's corners, x y z in mm a line");
  const CLI::Validator length = CLI::Range(1e-3, 1e6), place = CLI::Range(-1e6, 1e6);
  command.add_option("--lx", options.lx, "Length scale Lx, mm")->check(length);
  command.add_option("--ly", options.ly, "Length scale Ly, mm")->check(length);
  command.add_option("--x0", options.x0, "Model origin X0, mm (default 0)")->check(place);
  command.add_option("--y0", options.y0, "Model origin Y0, mm (default 0)")->check(place);
}

Outcome<std::optional<RunGeometry>> resolve_geometry(const CoefficientRun& run, const GeometryOptions& options) {
  const auto model_file = from_model_file(run, options);
  if (!model_file) return model_file.error();
  const bool any_option = options.points || options.lx || options.ly || options.x0 || options.y0;
  if (!*model_file && !any_option) return std::optional<RunGeometry>{};

  RunGeometry geometry;
  if (*model_file) {
    geometry.model = (*model_file)->model;
    geometry.refractive_index = (*model_file)->refractive_index;
    geometry.plates = (*model_file)->plates;
    geometry.systematic = (*model_file)->systematic;
  } else if (!options.lx || !options.ly) {
    return Problem{Exit::kUsage,
                   "the surface model's lengths are not known",
                   run.file,
                   "--lx and --ly, or --model",
                   "no " + model_file_path(run.file).filename().string(),
                   ""};
  }
  geometry.model.modes = run.modes;
  geometry.model.lx = options.lx.value_or(geometry.model.lx);
  geometry.model.ly = options.ly.value_or(geometry.model.ly);
  geometry.model.x0 = options.x0.value_or(geometry.model.x0);
  geometry.model.y0 = options.y0.value_or(geometry.model.y0);

  if (options.points) {
    const auto points = read_points(*options.points);
    if (!points) return points.error();
    for (const auto& p : *points) geometry.corners.emplace_back(p.x(), p.y());
    geometry.pattern = extent_of(geometry.corners);
    geometry.places = geometry.corners;
    if (geometry.pattern.x_min >= geometry.pattern.x_max || geometry.pattern.y_min >= geometry.pattern.y_max)
      return Problem{Exit::kUsage, "the points lie on one line along an axis", options.points->string(),
                     "points that span X and Y"};
  } else if (*model_file && (*model_file)->pattern) {
    geometry.pattern = *(*model_file)->pattern;
    geometry.places = grid_over(geometry.pattern);
  } else {
    return Problem{Exit::kUsage, "where the pattern lies is not known", run.file,
                   "--points FILE, or pattern_x and pattern_y in the model file"};
  }
  return std::optional(std::move(geometry));
}

SurfaceSampler::SurfaceSampler(const dsp::SurfaceModel<double>& model, const std::vector<dsp::Vec2<double>>& places)
    : basis_(static_cast<Eigen::Index>(places.size()), model.modes.size()) {
  dsp::Basis<double> basis;
  for (std::size_t i = 0; i < places.size(); ++i) {
    model.basis(places[i].x(), places[i].y(), basis);
    basis_.row(static_cast<Eigen::Index>(i)) = basis.value.transpose();
  }
}

}  // namespace srd::host
