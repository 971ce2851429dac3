// SPDX-License-Identifier: Apache-2.0
// What a pixel averages over, and what an unsharp mask makes of edges and noise: against closed forms.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>

#include "drivers/camera/simulator/renderer.hpp"
#include "drivers/camera/simulator/unsharp_mask.hpp"

namespace srd {
namespace {

constexpr double kDark = 60, kBright = 160;

// Straight from above through a medium without refraction: edges along rows and columns at places that are known.
Scene straight_scene(const std::string& image) {
  const auto scene = parse_scene(
      "[camera]\nwidth = 200\nheight = 120\nfx = 950.3\nfy = 950.3\ncx = 99.3\ncy = 58.7\ndistortion = []\n"
      "[pose]\nrotation = [0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0]\ntranslation_mm = [-40.0, -20.0, 950.0]\n"
      "[pattern]\nrows = 3\ncolumns = 5\n[tank]\nrefractive_index = 1.0\n"
      "[[surface.mode]]\nname = \"A00\"\nmean_mm = 80.0\n[light]\ndark = 60.0\nbright = 160.0\n[image]\n" +
          image,
      "scene");
  EXPECT_TRUE(scene) << scene.error().text();
  return *scene;
}

double phi(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2 * M_PI); }
double cdf(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }
// The mean of a blurred unit step over a pixel whose middle is d px behind it.
double square_step(double d, double s) {
  const auto whole = [&](double x) { return x * cdf(x / s) + s * phi(x / s); };
  return whole(d + 0.5) - whole(d - 0.5);
}

// One row of pixels half-way between two rows of corners, across the edge of the column of corners in the middle.
struct Profile {
  std::vector<double> distance, level;  // px from the edge towards larger u; 0: left of it .. 1: right of it
};
template <class At>
Profile profile_of(const Scene& scene, At at) {
  const auto pixels = truth_pixels(scene, 0).value();
  const double edge = pixels[7].x(), next = pixels[12].y();
  const int v = static_cast<int>(std::lround(0.5 * (pixels[7].y() + next)));
  Profile profile;
  const int middle = static_cast<int>(std::lround(edge));
  const bool rises = at(middle + 9, v) > at(middle - 9, v);
  for (int u = middle - 9; u <= middle + 9; ++u) {
    profile.distance.push_back(u - edge);
    const double level = (at(u, v) - kDark) / (kBright - kDark);
    profile.level.push_back(rises ? level : 1 - level);
  }
  return profile;
}
Profile rendered_levels(const Scene& scene) {
  auto renderer = Renderer::make(scene);
  EXPECT_TRUE(renderer) << renderer.error().text();
  std::vector<float> levels(static_cast<std::size_t>(scene.width() * scene.height()));
  renderer->render_levels(0, levels);
  return profile_of(scene,
                    [&](int u, int v) { return static_cast<double>(levels[static_cast<std::size_t>(v * scene.width() + u)]); });
}
GrayImage rendered_image(const Scene& scene) {
  auto renderer = Renderer::make(scene);
  EXPECT_TRUE(renderer) << renderer.error().text();
  GrayImage image{std::vector<std::uint8_t>(static_cast<std::size_t>(scene.width() * scene.height())), scene.width(),
                  scene.height()};
  renderer->render(0, {image.pixels.data(), image.width, image.height, image.width});
  return image;
}

TEST(RendererPixel, AnEdgeOfSquarePixelsIsTheLensesAveragedOverOnePixel) {
  for (const double blur : {0.2, 0.3, 0.5, 0.7, 1.5}) {
    const Scene scene = straight_scene("pixel = \"square\"\nblur_px = " + std::to_string(blur) + "\n");
    const Profile found = rendered_levels(scene);
    double worst = 0;
    for (std::size_t i = 0; i < found.level.size(); ++i)
      worst = std::max(worst, std::abs(found.level[i] - square_step(found.distance[i], blur)));
    std::printf("  blur %.1f px: %.5f of the edge at most\n", blur, worst);
    EXPECT_LT(worst, 1e-3) << blur;
  }
}

TEST(RendererPixel, TheDefaultIsANormalDistributionOfTheWholeBlur) {
  for (const double blur : {0.5, 0.7, 1.5}) {
    const Profile found = rendered_levels(straight_scene("blur_px = " + std::to_string(blur) + "\n"));
    for (std::size_t i = 0; i < found.level.size(); ++i)
      EXPECT_NEAR(found.level[i], cdf(found.distance[i] / std::sqrt(blur * blur + 1.0 / 12)), 2e-4) << blur;
  }
}

// Parts of a pixel change nothing of where things are: light, glare and corners.
TEST(RendererPixel, SquarePixelsSeeTheSameSceneAsNormalOnes) {
  const std::string more =
      "noise = 0.0\n[[glare]]\nu_px = 120.0\nv_px = 30.0\nradius_px = 6.0\npeak = 50.0\n[light]\ngradient_percent = 30.0\n"
      "gradient_direction_deg = 30.0\nvignette_percent = 20.0\ndark = 60.0\nbright = 160.0\n";
  const std::string view = "[camera]\nwidth = 400\nheight = 240\ncx = 220.0\ncy = 110.0\n";
  const auto normal = parse_scene(view + "[image]\nblur_px = 1.2\n" + more, "scene"),
             square = parse_scene(view + "[image]\npixel = \"square\"\nblur_px = 1.2\n" + more, "scene");
  ASSERT_TRUE(normal && square);
  auto a = Renderer::make(*normal), b = Renderer::make(*square);
  ASSERT_TRUE(a && b);
  const auto n = static_cast<std::size_t>(normal->width() * normal->height());
  std::vector<float> one(n), other(n);
  const auto seconds = [](auto& renderer, std::vector<float>& levels) {
    const auto began = std::chrono::steady_clock::now();
    renderer->render_levels(7, levels);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  };
  const double plain = seconds(a, one), parts = seconds(b, other);
  double worst = 0, sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    worst = std::max(worst, std::abs(static_cast<double>(one[i] - other[i])));
    sum += static_cast<double>(one[i] - other[i]);
  }
  std::printf("  %.4f grey levels at most, %.0f ms against %.0f ms a frame\n", worst, 1e3 * parts, 1e3 * plain);
  EXPECT_LT(worst, 0.3) << "of 100: the shape of the pixel at a blur of 1.2 px";
  EXPECT_NEAR(sum / static_cast<double>(n), 0, 1e-3);
}

TEST(RendererPixel, AnUnsharpMaskOvershootsByItsAmount) {
  for (const char* pixel : {"normal", "square"})
    for (const auto& [amount, radius] : {std::pair{0.5, 1.0}, {1.0, 1.0}, {1.0, 2.0}, {2.0, 0.7}}) {
      const Scene scene = straight_scene("pixel = \"" + std::string(pixel) +
                                         "\"\nblur_px = 0.6\nnoise = 0.0\nsharpen_amount = " + std::to_string(amount) +
                                         "\nsharpen_radius_px = " + std::to_string(radius) + "\n");
      const GrayImage image = rendered_image(scene);
      const Profile found = profile_of(scene, [&](int u, int v) { return static_cast<double>(image.view().row(v)[u]); });
      const auto step = [&](double d, double mask) {
        const double s = std::sqrt(0.36 + mask * mask);
        return std::string(pixel) == "square" ? square_step(d, s) : cdf(d / std::sqrt(s * s + 1.0 / 12));
      };
      double highest = 0;
      for (std::size_t i = 0; i < found.level.size(); ++i) {
        const double d = found.distance[i], expected = step(d, 0) + amount * (step(d, 0) - step(d, radius));
        EXPECT_NEAR(found.level[i], expected, 0.009) << pixel << " " << amount << " " << radius << " " << d;  // 0.5 is rounding
        highest = std::max(highest, found.level[i]);
      }
      EXPECT_GT(highest, 1.02) << "overshoot";
    }
}

// Of independent noise a kernel k leaves the sum of k^2: (1 + a)^2 - 2 a (1 + a) g0 + a^2 sum g^2.
TEST(RendererPixel, AnUnsharpMaskSharpensTheSensorsNoise) {
  constexpr double kAmount = 1, kRadius = 1, kNoise = 3;
  const auto scene = parse_scene(
      "[camera]\nwidth = 320\nheight = 320\n[light]\ndark = 120.0\nbright = 120.5\n[image]\nnoise = 3.0\n"
      "sharpen_amount = 1.0\nsharpen_radius_px = 1.0\n",
      "scene");
  ASSERT_TRUE(scene) << scene.error().text();
  double sum = 0, square = 0, weight = 0;
  for (int k = -8; k <= 8; ++k) weight += std::exp(-0.5 * k * k / (kRadius * kRadius));
  double squares = 0;
  for (int k = -8; k <= 8; ++k) squares += std::pow(std::exp(-0.5 * k * k / (kRadius * kRadius)) / weight, 2);
  const double g0 = 1 / (weight * weight),
               expected = std::sqrt((1 + kAmount) * (1 + kAmount) - 2 * kAmount * (1 + kAmount) * g0 +
                                    kAmount * kAmount * squares * squares);
  const GrayImage image = rendered_image(*scene);
  for (const std::uint8_t pixel : image.pixels) {
    sum += pixel;
    square += static_cast<double>(pixel) * pixel;
  }
  const auto n = static_cast<double>(image.pixels.size());
  const double deviation = std::sqrt(square / n - sum * sum / (n * n) - 1.0 / 12);
  EXPECT_NEAR(deviation / (kNoise * expected), 1, 0.02);
}

TEST(UnsharpMask, LeavesEvenGreyAndItsBordersAlone) {
  for (const double radius : {0.5, 1.0, 4.0}) {
    UnsharpMask mask(3, radius, 40, 24);
    for (int v = 0; v < 24; ++v)
      for (std::int32_t& level : mask.row(v)) level = 200 << 8;
    std::vector<std::uint8_t> pixels(40 * 24);
    mask.finish({pixels.data(), 40, 24, 40});
    EXPECT_EQ(pixels, std::vector<std::uint8_t>(40 * 24, 200)) << radius;
  }
}

}  // namespace
}  // namespace srd
