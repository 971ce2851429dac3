// 4000 draws of corner noise: the surface's error against the bound (19), each coefficient's scatter against its stated
// deviation, and the normalised squared error against its distribution.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "dsp/estimate/estimator.hpp"
#include "host/study/lower_bound.hpp"
#include "tests/fakes/synthetic_scene.hpp"

namespace srd::accuracy {
namespace {

constexpr int kDraws = 4000;
constexpr double kNoisePx = 0.1;

// Parameters, cameras.
class SurfaceNoise : public testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(SurfaceNoise, ErrorIsTheBoundAndAsStated) {
  const auto [parameters, cameras] = GetParam();
  const fakes::Scene scene = fakes::flume_scene(parameters, cameras);
  const study::Tank tank{scene.views, scene.points, scene.model, scene.media};
  auto estimator = dsp::SurfaceEstimator<double>::make(scene.model, scene.media, scene.points, {},
                                                       cameras * static_cast<int>(scene.points.size()))
                       .value();
  std::vector<std::vector<dsp::Observation<double>>> exact, seen;
  std::vector<dsp::CameraObservations<double>> observed;
  for (std::size_t view = 0; view < scene.views.size(); ++view) exact.push_back(scene.observe<double>(view));
  seen = exact;
  for (std::size_t view = 0; view < scene.views.size(); ++view) observed.push_back({&scene.views[view], seen[view]});

  std::mt19937_64 random(static_cast<std::uint64_t>(1000 * parameters + cameras));
  std::normal_distribution<double> normal(0, kNoisePx);
  dsp::Coefficients<double> squares = dsp::Coefficients<double>::Zero(parameters), variances = squares;
  double surface = 0, normalised = 0;
  const dsp::Coefficients<double> start = scene.truth;
  for (int draw = 0; draw < kDraws; ++draw) {
    for (std::size_t view = 0; view < seen.size(); ++view)
      for (std::size_t i = 0; i < seen[view].size(); ++i) {
        auto& corner = seen[view][i];
        const double du = normal(random), dv = normal(random);
        corner.pixel = exact[view][i].pixel + dsp::Vec2<double>(du, dv);
        corner.normalised = scene.views[view].camera.undistort(corner.pixel).value();
        corner.sigma = kNoisePx;
      }
    const auto found = estimator.estimate(observed, std::span(&start, 1));
    ASSERT_FALSE(dsp::failed(found.stop)) << to_string(found.stop);
    const dsp::Coefficients<double> error = found.coefficients - scene.truth;
    squares += error.cwiseAbs2();
    variances += found.standard_deviation.cwiseAbs2();
    surface += std::pow(study::surface_error(tank, found.coefficients, scene.truth), 2);
    normalised += error.dot(found.information * error);
  }
  dsp::InformationMatrix<double> information = dsp::InformationMatrix<double>::Zero(parameters, parameters);
  for (std::size_t view = 0; view < scene.views.size(); ++view)
    information += study::information_bound(tank, view, scene.truth, kNoisePx).value();
  const double bound = study::surface_bound(tank, information).value(), rms = std::sqrt(surface / kDraws);
  double worst = 1;
  for (int j = 0; j < parameters; ++j) {
    const double ratio = std::sqrt(squares[j] / variances[j]);
    EXPECT_NEAR(ratio, 1, 0.05) << "coefficient " << j;
    if (std::abs(ratio - 1) > std::abs(worst - 1)) worst = ratio;
  }
  // The variance factor comes from the same residuals: p times an F distribution, whose mean is p f / (f - 2).
  const double freedom = 2.0 * static_cast<double>(scene.points.size()) * cameras - parameters;
  const double expected = parameters * freedom / (freedom - 2);
  const double deviation = std::sqrt(2.0 * parameters * (1 + parameters / freedom) / kDraws);
  std::printf("%d parameters, %d cameras: surface %.4f mm, bound %.4f mm, ratio %.3f; worst scatter / stated %.3f; "
              "normalised error %.3f, expected %.3f +- %.3f\n",
              parameters, cameras, rms, bound, rms / bound, worst, normalised / kDraws, expected, deviation);
  EXPECT_NEAR(rms / bound, 1, 0.05);
  EXPECT_NEAR(normalised / kDraws, expected, 3.29 * deviation);
}

INSTANTIATE_TEST_SUITE_P(Slow, SurfaceNoise, testing::Combine(testing::Values(5, 8, 12), testing::Values(1, 2, 3)),
                         [](const auto& case_info) {
                           return std::to_string(std::get<0>(case_info.param)) + "Parameters" +
                                  std::to_string(std::get<1>(case_info.param)) + "Cameras";
                         });

}  // namespace
}  // namespace srd::accuracy
