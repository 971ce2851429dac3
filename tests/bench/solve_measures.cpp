// SPDX-License-Identifier: Apache-2.0
// The solve alone: 276 corners of the scene "frame" with noise, 12 parameters, from the surface of the frame before.
#include <cmath>
#include <memory>
#include <random>

#include "drivers/camera/simulator/renderer.hpp"
#include "dsp/estimate/estimator/estimator.hpp"
#include "tests/bench/measures.hpp"
#include "tests/bench/scenes.hpp"
#if SRD_WITH_CERES
#include "tests/bench/ceres_solve.hpp"
#endif

namespace srd::bench {

namespace {

constexpr double kNoisePx = 0.02;
constexpr std::uint64_t kFrame = 20;

template <class S>
struct Solve {
  dsp::View<S> view;
  std::vector<dsp::Vec3<S>> points;
  std::vector<dsp::Observation<S>> corners;
  dsp::Coefficients<S> start;
  dsp::SurfaceEstimator<S> estimator;

  static std::vector<dsp::Vec3<S>> cast(const Points& points) {
    std::vector<dsp::Vec3<S>> out;
    for (const auto& p : points) out.push_back(p.cast<S>());
    return out;
  }

  explicit Solve(const Scene& scene)
      : view(scene.view().cast<S>()),
        points(cast(scene.points())),
        start(scene.coefficients(kFrame - 1).cast<S>()),
        estimator(dsp::SurfaceEstimator<S>::make(scene.surface.cast<S>(), scene.media.cast<S>(), points, {},
                                                 static_cast<int>(points.size()))
                      .value()) {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal(0, kNoisePx);
    const auto truth = truth_pixels(scene, kFrame).value();
    for (std::size_t i = 0; i < truth.size(); ++i) {
      dsp::Observation<S> corner;
      corner.point = static_cast<int>(i);
      const double du = normal(random), dv = normal(random);
      corner.pixel = (truth[i] + dsp::Vec2<double>(du, dv)).cast<S>();
      corner.normalised = view.camera.undistort(corner.pixel).value();
      corner.sigma = static_cast<S>(kNoisePx);
      corners.push_back(corner);
    }
  }

  dsp::Estimate<S> run() {
    const dsp::CameraObservations<S> seen{&view, corners};
    return estimator.estimate(std::span(&seen, 1), std::span(&start, 1));
  }
};

}  // namespace

void add_solve_measures(std::vector<Measure>& measures) {
  const Scene scene = frame_scene();
  const auto wide = std::make_shared<Solve<double>>(scene);
  const auto narrow = std::make_shared<Solve<float>>(scene);
  const double cost = wide->run().cost, narrow_cost = static_cast<double>(narrow->run().cost);
  // Float rounds pixels of 2000 to 1e-4: 0.6 % of the noise.
  if (!(std::abs(narrow_cost / cost - 1) < 0.02)) refuse("float and double reach different costs");
  measures.push_back({"solve/ours_float", [=] { (void)narrow->run(); }});
  measures.push_back({"solve/ours_double", [=] { (void)wide->run(); }});
#if SRD_WITH_CERES
  const auto ceres = std::make_shared<CeresSolve>(wide->view, scene.surface, scene.media, wide->points, wide->corners);
  dsp::Coefficients<double> found = wide->start;
  const double ceres_cost = ceres->solve(found);
  if (!(std::abs(ceres_cost / cost - 1) < 1e-6))
    refuse("Ceres reaches a cost of " + std::to_string(ceres_cost) + ", ours of " + std::to_string(cost));
  measures.push_back({"solve/ceres", [=] {
                        dsp::Coefficients<double> a = wide->start;
                        (void)ceres->solve(a);
                      }});
#endif
}

}  // namespace srd::bench
