// SPDX-License-Identifier: Apache-2.0
// The water surface of one image, with dsp alone: detect corners, tell which is which, fit the surface.
// usage: one_frame IMAGE.pgm    an image of tests/data/flume-small, saved as 8-bit PGM; prints a mode and its deviation a line, mm
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "dsp/estimate/estimator/estimator.hpp"
#include "dsp/frontend/board_finder.hpp"
#include "dsp/optics/ray_trace.hpp"

namespace {

using namespace srd;       // NOLINT: a program of one file
using namespace srd::dsp;  // NOLINT

struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
  [[nodiscard]] GrayView view() const { return {pixels.data(), width, height, width}; }
};

std::optional<Image> read_pgm(const char* file) {
  std::ifstream in(file, std::ios::binary);
  std::string kind;
  Image image;
  int most = 0;
  if (!(in >> kind >> image.width >> image.height >> most) || kind != "P5" || most != 255) return std::nullopt;
  if (image.width < 1 || image.width > 10000 || image.height < 1 || image.height > 10000) return std::nullopt;
  in.get();  // one white space, then the pixels
  image.pixels.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  if (!in.read(reinterpret_cast<char*>(image.pixels.data()), static_cast<std::streamsize>(image.pixels.size())))
    return std::nullopt;
  return image;
}

// What tests/data/flume-small was seen with: calibration.yml, pose.yml, points.txt, optics.toml.
constexpr int kColumns = 11, kRows = 21;  // corners along X and along Y
constexpr double kSquareMm = 20, kLevelMm = 80;

View<double> flume_view() {
  const std::array<double, 5> distortion{-0.21, 0.09, -0.004, -0.0035, 0.3};
  View<double> view;
  view.camera = CameraModel<double>::make(1075, 1075, 323.4, 157.7, distortion).value();
  view.pose.rotation << 1.9758591461345072e-02, 9.9909522970671183e-01, -3.7660590021348306e-02,  //
      9.4966250606576574e-01, -6.9751138396383083e-03, 3.1319717808405206e-01,                    //
      3.1265111967871317e-01, -4.1953185388197929e-02, -9.4894109806638183e-01;
  view.pose.translation << -2.1004452861412804e+02, -1.0586103950678674e+02, 9.7451256344585488e+02;
  return view;
}

std::vector<Vec3<double>> board_points() {
  std::vector<Vec3<double>> points;
  for (int i = 0; i < kColumns; ++i)
    for (int j = 0; j < kRows; ++j) points.emplace_back(i * kSquareMm, j * kSquareMm, 0);
  return points;
}

// The grid says which corner is whose neighbour. Which of its ends is the board's first corner is told by where the camera
// would see the board through level water: the way round, of the four that fit the grid's shape, that lies nearest to it.
std::vector<Observation<double>> identify(const CornerGrid& grid, std::span<const CornerFit> corners, const View<double>& view,
                                          const std::vector<Vec2<double>>& expected) {
  const bool turned = grid.rows == kColumns;  // the image's rows run along X
  std::vector<Observation<double>> best;
  double least = HUGE_VAL;
  for (const bool flip_x : {false, true}) {
    for (const bool flip_y : {false, true}) {
      std::vector<Observation<double>> seen;
      double sum = 0;
      for (int x = 0; x < kColumns; ++x) {
        for (int y = 0; y < kRows; ++y) {
          const int along_x = flip_x ? kColumns - 1 - x : x, along_y = flip_y ? kRows - 1 - y : y;
          const int corner = turned ? grid.at(along_x, along_y) : grid.at(along_y, along_x);
          if (corner < 0) continue;
          const Corner& found = corners[static_cast<std::size_t>(corner)].corner;
          Observation<double> one;
          one.point = x * kRows + y;
          one.pixel = {found.u.to<double>(), found.v.to<double>()};
          one.sigma = found.sigma_q12 / 4096.0;
          const auto undistorted = view.camera.undistort(one.pixel);
          if (!undistorted) continue;
          one.normalised = *undistorted;
          sum += (one.normalised - expected[static_cast<std::size_t>(one.point)]).squaredNorm();
          seen.push_back(one);
        }
      }
      if (sum < least) {
        least = sum;
        best = std::move(seen);
      }
    }
  }
  return best;
}

int fail(const char* what) {
  std::fprintf(stderr, "one_frame: %s\n", what);
  return 3;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: one_frame IMAGE.pgm\n");
    return 2;
  }
  const std::optional<Image> image = read_pgm(argv[1]);
  if (!image) return fail("expected an 8-bit PGM (P5)");

  // The model: five modes over the flume; the water is level at first.
  const SurfaceModel<double> model{ModeList::standard(5).value(), 240, 440, 0, 0};
  const Media<double> media{1, 1.333, {}, 0};
  Coefficients<double> level = Coefficients<double>::Zero(model.modes.size());
  level[0] = kLevelMm;

  // Corners, to a hundredth of a pixel, and the grid that they form.
  BoardFinder finder(image->width, image->height, 1000);
  const Result<CornerGrid> grid = finder.find(image->view(), {}, BoardSize{kColumns, kRows});
  if (!grid) return fail(to_string(grid.error()));
  const bool upright = grid->rows == kRows && grid->columns == kColumns;
  if (!upright && !(grid->rows == kColumns && grid->columns == kRows)) return fail("not the whole board is seen");

  // Where the camera would see each corner through level water.
  const View<double> view = flume_view();
  const std::vector<Vec3<double>> points = board_points();
  std::vector<Vec2<double>> expected;
  for (const Vec3<double>& point : points) {
    const Result<Vec2<double>> dry = view.normalised(point);
    Trace<double> ray;
    Mat2<double> derivative;
    const auto seen = dry ? see_through(view, model, level, media, point, *dry, ray, derivative) : dry;
    if (!seen) return fail(to_string(seen.error()));
    expected.push_back(*seen);
  }
  const std::vector<Observation<double>> corners = identify(*grid, finder.corners(), view, expected);

  // The surface that bends the light so.
  auto estimator = SurfaceEstimator<double>::make(model, media, points, {}, static_cast<int>(points.size()));
  if (!estimator) return fail(to_string(estimator.error()));
  const CameraObservations<double> seen{&view, corners};
  const Estimate<double> surface = estimator->estimate({&seen, 1}, {&level, 1});
  if (failed(surface.stop)) return fail(to_string(surface.stop));
  std::printf("corners %d, %.4f px rms\n", surface.corners_used, surface.reprojection_rms);
  for (int i = 0; i < model.modes.size(); ++i)
    std::printf("%s %.4f %.4f\n", model.modes[i].name().data(), surface.coefficients[i], surface.standard_deviation[i]);
  return 0;
}
