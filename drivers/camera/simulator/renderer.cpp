// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/simulator/renderer.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "drivers/camera/simulator/stable_math.hpp"
#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

constexpr double kPixelAreaVariance = 1.0 / 12;                          // px^2, of a square pixel per axis
constexpr double kMaxGridError = 0.0003;                                 // px
constexpr double kSpotReach = 5;                                         // radii
constexpr std::uint64_t kReferenceFrame = (std::uint64_t{1} << 47) - 1;  // its noise is no frame's

double whole_blur(const Scene& scene) { return std::sqrt(scene.blur_px * scene.blur_px + kPixelAreaVariance); }

// Parts of a pixel's side, each at most as wide as the blur: what remains of taking a part for a normal distribution is then
// below 1e-3 of an edge's height at 0.2 px of blur, and 4e-5 at 0.5 px.
int parts_of(const Scene& scene) {
  return scene.pixel == PixelArea::kSquare ? std::max(3, static_cast<int>(std::ceil(1 / scene.blur_px - 1e-9))) : 1;
}

// The same view with so many pixels in place of each, both ways.
Scene finer(const Scene& scene, int parts) {
  if (parts == 1) return scene;
  Scene fine = scene;
  const double k = parts, shift = 0.5 * (k - 1);
  Calibration& c = fine.calibration;
  const dsp::CameraModel<double>& camera = scene.calibration.camera;
  c.camera = dsp::CameraModel<double>::make(k * camera.fx(), k * camera.fy(), k * camera.cx() + shift, k * camera.cy() + shift,
                                            c.distortion)
                 .value();
  c.image_width *= parts;
  c.image_height *= parts;
  fine.blur_px *= k;
  for (GlareSpot& spot : fine.glare) {
    spot.u_px = k * spot.u_px + shift;
    spot.v_px = k * spot.v_px + shift;
    for (double* length : {&spot.speed_u_px_s, &spot.speed_v_px_s, &spot.radius_px}) *length *= k;
  }
  return fine;
}

std::unique_ptr<PatternMap> make_map(const Scene& scene, int step) {
  return std::make_unique<PatternMap>(scene.view(), scene.width(), scene.height(), scene.pattern.square_mm, whole_blur(scene),
                                      step);
}

}  // namespace

DryTank dry_tank(const Scene& scene) {
  DryTank dry{{}, dsp::Coefficients<double>(1), scene.media};
  const dsp::Mode level;
  dry.model.modes = dsp::ModeList::make({&level, 1}).value();
  dry.media.water = dry.media.air;
  double plates = 0;
  for (int i = 0; i < scene.media.n_layers; ++i) plates += scene.media.layers[static_cast<std::size_t>(i)].thickness;
  dry.coefficients[0] = plates + 1;  // mm; above the plates, so that every ray meets it first
  return dry;
}

Renderer::Renderer(const Scene& scene)
    : scene_(scene),
      fine_(parts_of(scene)),
      drawn_(finer(scene, fine_)),
      board_(scene.pattern.rows, scene.pattern.columns, scene.pattern.border_squares, scene.pattern.origin_dark,
             scene.pattern.margin),
      noise_(scene.seed, scene.noise) {
  const auto width = static_cast<std::size_t>(scene.width());
  for (auto* values : {&pattern_row_.x, &pattern_row_.y, &pattern_row_.wx, &pattern_row_.wy, &pattern_row_.rho, &drawn_levels_})
    values->resize(static_cast<std::size_t>(drawn_.width()));
  levels_.resize(width);
  levels_q8_.resize(width);
  if (scene.sharpen_amount > 0)
    mask_ = std::make_unique<UnsharpMask>(scene.sharpen_amount, scene.sharpen_radius_px, scene.width(), scene.height());
  for (const GlareSpot& spot : drawn_.glare) {
    PlacedSpot placed;
    placed.columns.resize(static_cast<std::size_t>(2 * kSpotReach * spot.radius_px) + 3);
    spots_.push_back(std::move(placed));
  }
}

// Over the longest period of the motion, a minute at most.
double Renderer::sampled_grid_error() {
  constexpr int kSamples = 6;
  double period = 0;
  for (const ModeMotion& motion : scene_.motions)
    if (motion.frequency_hz > 0) period = std::max(period, 1 / motion.frequency_hz);
  period = std::min(period, 60.0);
  double worst = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double time = period * (i + 0.3) / kSamples;
    map_->trace(scene_.surface, scene_.coefficients(static_cast<std::uint64_t>(time * scene_.rate_hz)), scene_.media);
    worst = std::max(worst, map_->interpolation_error() / fine_);
    if (period == 0) break;
  }
  return worst;
}

Outcome<Renderer> Renderer::make(const Scene& scene) {
  const auto problem = [&](std::string what, std::string expected, std::string found, std::string advice) {
    return Problem{Exit::kUsage,     "scene: " + std::move(what), scene.name, std::move(expected), std::move(found),
                   std::move(advice)};
  };
  Renderer renderer(scene);
  const Scene& drawn = renderer.drawn_;
  const auto pixels = truth_pixels(drawn, 0);
  if (!pixels)
    return problem("a corner of the pattern cannot be seen through the water", "a camera above the water",
                   to_string(pixels.error()), "check the pose, the distortion and the modes");
  for (const int step : {8, 4, 2, 1}) {
    renderer.map_ = make_map(drawn, step);
    renderer.grid_error_px_ = step == 1 ? 0 : renderer.sampled_grid_error();
    if (renderer.grid_error_px_ <= kMaxGridError) break;
  }
  // Neighbouring edges must not blur into each other: looked at where the corners are.
  renderer.map_->trace(scene.surface, scene.coefficients(0), scene.media);
  for (const dsp::Vec2<double>& pixel : *pixels) {
    const auto u = std::lround(pixel.x()), v = std::lround(pixel.y());
    if (u < 0 || v < 0 || u >= drawn.width() || v >= drawn.height()) continue;
    renderer.map_->row(static_cast<int>(v), renderer.pattern_row_);
    const auto at = static_cast<std::size_t>(u);
    const double narrowest = static_cast<double>(std::min(renderer.pattern_row_.wx[at], renderer.pattern_row_.wy[at]));
    if (!(narrowest >= FilteredCheckerboard::kMinWeight))
      return problem("the squares are too small for the blur",
                     "squares of at least 8 times the blur and pixel together, " +
                         number_text(std::round(80 * whole_blur(drawn) / renderer.fine_) / 10) + " px",
                     number_text(std::round(10 * narrowest * whole_blur(drawn) / renderer.fine_) / 10) + " px",
                     "use larger squares, less blur or a closer camera");
  }
  return renderer;
}

void Renderer::place_glare(std::uint64_t frame) {
  const double time = static_cast<double>(frame) / scene_.rate_hz;
  // A spot leaves the image before it comes in again.
  const auto wrapped = [](double at, double reach, double side) {
    const double span = side + 2 * reach;
    const double turned = std::fmod(at + reach, span);
    return (turned < 0 ? turned + span : turned) - reach;
  };
  for (std::size_t i = 0; i < spots_.size(); ++i) {
    const GlareSpot& spot = drawn_.glare[i];
    PlacedSpot& placed = spots_[i];
    const double reach = kSpotReach * spot.radius_px;
    const double u = wrapped(spot.u_px + spot.speed_u_px_s * time, reach, drawn_.width());
    placed.v = wrapped(spot.v_px + spot.speed_v_px_s * time, reach, drawn_.height());
    placed.radius = spot.radius_px;
    placed.peak = spot.peak;
    placed.first = std::max(0, static_cast<int>(std::ceil(u - reach)));
    const int last = std::min(drawn_.width() - 1, static_cast<int>(std::floor(u + reach)));
    placed.count = std::clamp(last - placed.first + 1, 0, static_cast<int>(placed.columns.size()));
    for (int k = 0; k < placed.count; ++k) {
      const double d = (placed.first + k - u) / spot.radius_px;
      placed.columns[static_cast<std::size_t>(k)] = static_cast<float>(stable::exp_negative(-0.5 * d * d));
    }
  }
}

void Renderer::levels_row(int v, bool glare) {
  if (fine_ == 1) {
    drawn_row(v, glare);
    std::swap(drawn_levels_, levels_);
    return;
  }
  std::fill(levels_.begin(), levels_.end(), 0.0F);
  for (int part = 0; part < fine_; ++part) {
    drawn_row(v * fine_ + part, glare);
    const float* from = drawn_levels_.data();
    for (float& level : levels_)
      for (int k = 0; k < fine_; ++k) level += *from++;
  }
  const float share = 1.0F / static_cast<float>(fine_ * fine_);
  for (float& level : levels_) level *= share;
}

// A row of drawn_.
void Renderer::drawn_row(int v, bool glare) {
  map_->row(v, pattern_row_);
  const Light& light = drawn_.light;
  const int width = drawn_.width();
  // Brightness against the image's centre: 1 + slope along the direction - fall with the squared distance.
  const double cu = 0.5 * (width - 1), cv = 0.5 * (drawn_.height() - 1);
  const double du = std::cos(light.gradient_direction_rad), dv = std::sin(light.gradient_direction_rad);
  // To the middle of the scene's outermost pixels, whatever parts they have.
  const double far_u = fine_ * (0.5 * (scene_.width() - 1)), far_v = fine_ * (0.5 * (scene_.height() - 1));
  const double slope = light.gradient_percent / 100 / (2 * (std::abs(du) * far_u + std::abs(dv) * far_v));
  const double fall = light.vignette_percent / 100 / (far_u * far_u + far_v * far_v);
  const double y = v - cv;
  const auto constant = static_cast<float>(1 + slope * dv * y - fall * y * y);
  const auto linear = static_cast<float>(slope * du), square = static_cast<float>(-fall);
  const auto dark = static_cast<float>(light.dark), contrast = static_cast<float>(light.bright - light.dark);
  const bool even = linear == 0 && square == 0;
  for (int u = 0; u < width; ++u) {
    const auto at = static_cast<std::size_t>(u);
    const float wx = pattern_row_.wx[at];
    float level = 0;  // no pattern in sight: the inside of the tank
    if (wx > 0) level = board_.level(pattern_row_.x[at], pattern_row_.y[at], wx, pattern_row_.wy[at], pattern_row_.rho[at]);
    const float x = static_cast<float>(u) - static_cast<float>(cu);
    const float gain = even ? constant : constant + x * (linear + x * square);
    drawn_levels_[at] = (dark + contrast * level) * std::max(gain, 0.0F);
  }
  if (!glare) return;
  for (const PlacedSpot& spot : spots_) {
    const double d = (v - spot.v) / spot.radius;
    if (std::abs(d) > kSpotReach) continue;
    const auto factor = static_cast<float>(spot.peak * stable::exp_negative(-0.5 * d * d));
    for (int k = 0; k < spot.count; ++k)
      drawn_levels_[static_cast<std::size_t>(spot.first + k)] += factor * spot.columns[static_cast<std::size_t>(k)];
  }
}

void Renderer::finish(std::uint64_t frame, bool glare, const GrayBuffer& image) {
  assert(image.width == scene_.width() && image.height == scene_.height());
  for (int v = 0; v < image.height; ++v) {
    levels_row(v, glare);
    const std::span<std::int32_t> row = mask_ ? mask_->row(v) : std::span(levels_q8_);
    for (std::size_t u = 0; u < levels_.size(); ++u) row[u] = static_cast<std::int32_t>(levels_[u] * 256 + 0.5F);
    if (mask_)
      noise_.add_row(frame, v, row);
    else
      noise_.finish_row(frame, v, row, image.pixels + static_cast<std::int64_t>(v) * image.stride_bytes);
  }
  if (mask_) mask_->finish(image);
}

void Renderer::render(std::uint64_t frame, const GrayBuffer& image) {
  map_->trace(scene_.surface, scene_.coefficients(frame), scene_.media);
  place_glare(frame);
  finish(frame, true, image);
}

void Renderer::render_reference(const GrayBuffer& image) {
  const DryTank dry = dry_tank(scene_);
  map_->trace(dry.model, dry.coefficients, dry.media);
  finish(kReferenceFrame, false, image);
}

void Renderer::render_levels(std::uint64_t frame, std::span<float> levels) {
  map_->trace(scene_.surface, scene_.coefficients(frame), scene_.media);
  place_glare(frame);
  for (int v = 0; v < scene_.height(); ++v) {
    levels_row(v, true);
    std::copy(levels_.begin(), levels_.end(), levels.begin() + static_cast<std::ptrdiff_t>(v) * scene_.width());
  }
}

void Renderer::render_levels(const dsp::Coefficients<double>& coefficients, std::span<float> levels) {
  map_->trace(scene_.surface, coefficients, scene_.media);
  for (int v = 0; v < scene_.height(); ++v) {
    levels_row(v, false);
    std::copy(levels_.begin(), levels_.end(), levels.begin() + static_cast<std::ptrdiff_t>(v) * scene_.width());
  }
}

namespace {

Result<std::vector<dsp::Vec2<double>>> pixels_of(const Scene& scene, const dsp::SurfaceModel<double>& model,
                                                 const dsp::Coefficients<double>& a, const dsp::Media<double>& media) {
  std::vector<dsp::Vec2<double>> pixels;
  const dsp::View<double> view = scene.view();
  for (const dsp::Vec3<double>& point : scene.points()) {
    const auto start = view.normalised(point);
    if (!start) return start.error();
    dsp::Trace<double> traced;
    dsp::Mat2<double> by_xy;
    const auto xy = dsp::see_through(view, model, a, media, point, *start, traced, by_xy);
    if (!xy) return xy.error();
    pixels.push_back(view.camera.pixel(*xy));
  }
  return pixels;
}

}  // namespace

Result<std::vector<dsp::Vec2<double>>> truth_pixels(const Scene& scene, std::uint64_t frame) {
  return pixels_of(scene, scene.surface, scene.coefficients(frame), scene.media);
}

Result<std::vector<dsp::Vec2<double>>> dry_truth_pixels(const Scene& scene) {
  const DryTank dry = dry_tank(scene);
  return pixels_of(scene, dry.model, dry.coefficients, dry.media);
}

}  // namespace srd
