// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/simulator/scene.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cassert>
#include <cmath>

#include "drivers/geometry/pose.hpp"
#include "drivers/support/text_file.hpp"
#include "drivers/support/toml_reader.hpp"
#include "dsp/optics/refractive_index.hpp"

namespace srd {

namespace {

constexpr double kDegree = M_PI / 180;
constexpr int kMaxSide = 16384;  // px
constexpr double kMaxMm = 1e5;

template <class T, class U>
void set(T& value, const std::optional<U>& given) {
  if (given) value = static_cast<T>(*given);
}

NumberRange range(double least, double most, const char* unit = "") { return {least, most, unit}; }

void read_camera(TomlTable table, Scene& scene) {
  Calibration& c = scene.calibration;
  set(c.image_width, table.integer("width", range(32, kMaxSide, "px")));
  set(c.image_height, table.integer("height", range(32, kMaxSide, "px")));
  double fx = c.camera.fx(), fy = c.camera.fy(), cx = c.camera.cx(), cy = c.camera.cy();
  set(fx, table.number("fx", range(1, 1e6, "px")));
  set(fy, table.number("fy", range(1, 1e6, "px")));
  set(cx, table.number("cx", range(-1e6, 1e6, "px")));
  set(cy, table.number("cy", range(-1e6, 1e6, "px")));
  if (const auto numbers = table.numbers("distortion")) c.distortion = *numbers;
  const auto camera = dsp::CameraModel<double>::make(fx, fy, cx, cy, c.distortion);
  if (camera)
    c.camera = *camera;
  else
    table.complain("distortion", "0, 4, 5, 8, 12 or 14 numbers", std::to_string(c.distortion.size()));
  set(scene.rate_hz, table.number("rate_hz", range(1e-3, 1e6, "Hz")));
  set(scene.exposure_us, table.integer("exposure_us", range(0, 4e9, "us")));
}

void read_pose(TomlTable table, Scene& scene) {
  const bool by_matrix = table.has("rotation") || table.has("translation_mm");
  const auto centre = table.numbers("centre_mm", 3, range(-kMaxMm, kMaxMm, "mm"));
  const auto target = table.numbers("target_mm", 3, range(-kMaxMm, kMaxMm, "mm"));
  const auto roll = table.number("roll_deg", range(-360, 360, "degrees"));
  const auto rotation = table.numbers("rotation", 9, range(-1.001, 1.001));
  const auto translation = table.numbers("translation_mm", 3, range(-kMaxMm, kMaxMm, "mm"));
  const auto vector = [](const std::vector<double>& v) { return dsp::Vec3<double>(v[0], v[1], v[2]); };
  if (by_matrix) {
    for (const char* key : {"centre_mm", "target_mm", "roll_deg"})
      if (table.has(key)) table.complain(key, "either centre_mm, target_mm, roll_deg or rotation, translation_mm", "both");
    if (!table.has("rotation")) table.missing("rotation", "nine numbers beside translation_mm");
    if (!table.has("translation_mm")) table.missing("translation_mm", "three numbers beside rotation");
    if (!rotation || !translation) return;
    const dsp::Mat3<double> r = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation->data());
    if ((r * r.transpose() - dsp::Mat3<double>::Identity()).cwiseAbs().maxCoeff() > 1e-6 || r.determinant() < 0)
      table.complain("rotation", "an orthonormal matrix of determinant +1 (to 1e-6)", "another matrix");
    scene.pose = {r, vector(*translation)};
  } else if (table.has("centre_mm") || table.has("target_mm") || table.has("roll_deg")) {
    for (const char* key : {"centre_mm", "target_mm"})
      if (!table.has(key)) table.missing(key, "three numbers (mm): the pose is given as a whole");
    if (!centre || !target) return;
    const auto pose = look_at(vector(*centre), vector(*target), roll.value_or(0) * kDegree);
    if (!pose) {
      table.complain("target_mm", "a point that the camera does not see along Y", "centre and target on one such line");
      return;
    }
    scene.pose = *pose;
  }
  const double height = scene.pose.centre().z();
  if (!(height > 0))
    table.complain(by_matrix ? "translation_mm" : "centre_mm", "a camera above the pattern (Z > 0)",
                   "Z = " + number_text(height) + " mm");
}

void read_pattern(TomlTable table, BoardPattern& pattern) {
  set(pattern.rows, table.integer("rows", range(2, 1000)));
  set(pattern.columns, table.integer("columns", range(2, 1000)));
  set(pattern.square_mm, table.number("square_mm", range(1e-3, 1e4, "mm")));
  set(pattern.border_squares, table.integer("border_squares", range(1, 1000)));
  set(pattern.margin, table.number("margin", range(0, 1)));
  if (const auto word = table.choice("origin_square", {"dark", "bright"})) pattern.origin_dark = *word == "dark";
}

void read_tank(TomlTable table, Scene& scene) {
  const bool by_index = table.has("refractive_index");
  set(scene.media.water, table.number("refractive_index", range(1, 2)));
  const auto temperature =
      table.number("water_temperature_c", range(dsp::kWaterTemperatureC.least, dsp::kWaterTemperatureC.most, "degrees C"));
  const auto salinity = table.number("salinity_per_mille",
                                     range(dsp::kWaterSalinityPerMille.least, dsp::kWaterSalinityPerMille.most, "per mille"));
  const auto wavelength =
      table.number("wavelength_nm", range(dsp::kWaterWavelengthNm.least, dsp::kWaterWavelengthNm.most, "nm"));
  int given = 0;
  for (const char* key : {"water_temperature_c", "salinity_per_mille", "wavelength_nm"}) {
    if (!table.has(key)) continue;
    ++given;
    if (by_index) table.complain(key, "either refractive_index or temperature, salinity and wavelength", "both");
  }
  if (given > 0 && given < 3 && !by_index)
    for (const char* key : {"water_temperature_c", "salinity_per_mille", "wavelength_nm"})
      if (!table.has(key)) table.missing(key, "temperature, salinity and wavelength together");
  if (temperature && salinity && wavelength)
    if (const auto index = dsp::water_refractive_index(*temperature, *salinity, *wavelength)) scene.media.water = *index;
  if (!table.has("plate")) return;
  scene.media.n_layers = 0;
  for (TomlTable plate : table.tables("plate")) {
    dsp::Layer<double> layer;
    layer.index = 1.5;
    set(layer.thickness, plate.number("thickness_mm", range(0, kMaxMm, "mm")));
    set(layer.index, plate.number("refractive_index", range(1, 3)));
    if (scene.media.n_layers == dsp::kMaxLayers) {
      table.complain("plate", "at most " + std::to_string(dsp::kMaxLayers) + " plates", "more");
      return;
    }
    scene.media.layers[static_cast<std::size_t>(scene.media.n_layers++)] = layer;
  }
}

void read_surface(TomlTable table, Scene& scene) {
  set(scene.surface.lx, table.number("lx_mm", range(1e-3, kMaxMm, "mm")));
  set(scene.surface.ly, table.number("ly_mm", range(1e-3, kMaxMm, "mm")));
  if (const auto origin = table.numbers("origin_mm", 2, range(-kMaxMm, kMaxMm, "mm"))) {
    scene.surface.x0 = (*origin)[0];
    scene.surface.y0 = (*origin)[1];
  }
  if (!table.has("mode")) return;
  scene.motions.clear();
  std::vector<dsp::Mode> modes;
  for (TomlTable entry : table.tables("mode")) {
    ModeMotion motion;
    const auto name = entry.text("name");
    if (!entry.has("name")) entry.missing("name", "a mode: A00, B, C, A10, ..");
    if (name) {
      const auto mode = dsp::Mode::parse(*name);
      if (!mode) entry.complain("name", "a mode: A00, B, C, A10, ..", "\"" + *name + "\"");
      motion.mode = mode.value_or(dsp::Mode{});
    }
    set(motion.mean_mm, entry.number("mean_mm", range(-kMaxMm, kMaxMm, "mm")));
    set(motion.amplitude_mm, entry.number("amplitude_mm", range(-kMaxMm, kMaxMm, "mm")));
    set(motion.frequency_hz, entry.number("frequency_hz", range(0, 1e4, "Hz")));
    if (const auto phase = entry.number("phase_deg")) motion.phase_rad = *phase * kDegree;
    modes.push_back(motion.mode);
    scene.motions.push_back(motion);
  }
  const auto list = dsp::ModeList::make(modes);
  if (list)
    scene.surface.modes = *list;
  else
    table.complain("mode", "1 to 24 different modes", std::to_string(modes.size()) + " with repetitions");
}

void read_light(TomlTable table, Light& light) {
  set(light.dark, table.number("dark", range(0, 255, "grey levels")));
  set(light.bright, table.number("bright", range(0, 255, "grey levels")));
  set(light.gradient_percent, table.number("gradient_percent", range(-200, 200, "percent")));
  if (const auto direction = table.number("gradient_direction_deg")) light.gradient_direction_rad = *direction * kDegree;
  set(light.vignette_percent, table.number("vignette_percent", range(0, 100, "percent")));
  if (light.dark >= light.bright)
    table.complain("dark", "less than bright", number_text(light.dark) + " and " + number_text(light.bright));
}

void read_glare(TomlTable root, Scene& scene) {
  if (!root.has("glare")) return;
  scene.glare.clear();
  for (TomlTable entry : root.tables("glare")) {
    GlareSpot spot;
    set(spot.u_px, entry.number("u_px", range(-kMaxSide, kMaxSide, "px")));
    set(spot.v_px, entry.number("v_px", range(-kMaxSide, kMaxSide, "px")));
    set(spot.speed_u_px_s, entry.number("speed_u_px_s", range(-1e6, 1e6, "px/s")));
    set(spot.speed_v_px_s, entry.number("speed_v_px_s", range(-1e6, 1e6, "px/s")));
    set(spot.radius_px, entry.number("radius_px", range(0.5, 1000, "px")));
    set(spot.peak, entry.number("peak", range(0, 1e4, "grey levels")));
    scene.glare.push_back(spot);
  }
}

// Water stands over the plates at all times, whatever the phases.
void check_depth(TomlTable table, const Scene& scene) {
  double lowest = 0, plates = 0;
  for (const ModeMotion& motion : scene.motions) {
    const bool level = motion.mode == dsp::Mode{};
    lowest += level                                          ? motion.mean_mm - std::abs(motion.amplitude_mm)
              : motion.mode.kind == dsp::Mode::Kind::kCosine ? -std::abs(motion.mean_mm) - std::abs(motion.amplitude_mm)
                                                             : 0;
  }
  for (int i = 0; i < scene.media.n_layers; ++i) plates += scene.media.layers[static_cast<std::size_t>(i)].thickness;
  if (lowest > plates) return;
  table.complain("mode", "water above the pattern and its plates (" + number_text(plates) + " mm) at all times",
                 "a level that can fall to " + number_text(lowest) + " mm", "raise mean_mm of A00");
}

Outcome<Scene> scene_of(const TomlFile& file, Scene scene) {
  TomlTable root = file.root();
  if (const auto name = root.text("name")) scene.name = *name;
  set(scene.seed, root.integer("seed", range(0, 9e18)));
  set(scene.frames, root.integer("frames", range(1, 1e6)));
  set(scene.reference, root.boolean("reference"));
  read_camera(root.table("camera"), scene);
  read_pose(root.table("pose"), scene);
  read_pattern(root.table("pattern"), scene.pattern);
  read_tank(root.table("tank"), scene);
  TomlTable surface = root.table("surface");
  read_surface(surface, scene);
  check_depth(surface, scene);
  read_light(root.table("light"), scene.light);
  TomlTable image = root.table("image");
  if (const auto word = image.choice("pixel", {"normal", "square"}))
    scene.pixel = *word == "square" ? PixelArea::kSquare : PixelArea::kNormal;
  set(scene.blur_px, image.number("blur_px", range(scene.pixel == PixelArea::kSquare ? 0.2 : 0.5, 20, "px")));
  set(scene.noise, image.number("noise", range(0, 64, "grey levels")));
  set(scene.sharpen_amount, image.number("sharpen_amount", range(0, 3)));
  set(scene.sharpen_radius_px, image.number("sharpen_radius_px", range(0.5, 4, "px")));
  read_glare(root, scene);
  if (const Outcome<void> done = file.finish(); !done) return done.error();
  return scene;
}

}  // namespace

Points Scene::points() const {
  Points points;
  for (int row = 0; row < pattern.rows; ++row)
    for (int column = 0; column < pattern.columns; ++column)
      points.emplace_back(row * pattern.square_mm, column * pattern.square_mm, 0);
  return points;
}

std::int64_t Scene::time_ns(std::uint64_t frame) const {
  return static_cast<std::int64_t>(std::llround(static_cast<double>(frame) * 1e9 / rate_hz));
}

dsp::Coefficients<double> Scene::coefficients(std::uint64_t frame) const {
  const double t = static_cast<double>(frame) / rate_hz;
  dsp::Coefficients<double> a(static_cast<Eigen::Index>(motions.size()));
  for (std::size_t j = 0; j < motions.size(); ++j) {
    const ModeMotion& motion = motions[j];
    // Whole turns go first: an endless run keeps its precision.
    const double turns = std::fmod(motion.frequency_hz * t, 1.0);
    a[static_cast<Eigen::Index>(j)] = motion.mean_mm + motion.amplitude_mm * std::sin(2 * M_PI * turns + motion.phase_rad);
  }
  return a;
}

Result<dsp::Pose<double>> look_at(const dsp::Vec3<double>& centre, const dsp::Vec3<double>& target, double roll_rad) {
  const dsp::Vec3<double> forward = (target - centre).normalized();
  dsp::Vec3<double> right = dsp::Vec3<double>::UnitY() - forward.y() * forward;
  if (!(right.norm() > 1e-6)) return Errc::kSingular;
  right.normalize();
  const dsp::Vec3<double> down = forward.cross(right);
  const double c = std::cos(roll_rad), s = std::sin(roll_rad);
  dsp::Pose<double> pose;
  pose.rotation.row(0) = (c * right + s * down).transpose();
  pose.rotation.row(1) = (c * down - s * right).transpose();
  pose.rotation.row(2) = forward.transpose();
  pose.translation = -pose.rotation * centre;
  return pose;
}

const Scene& default_scene() {
  static const Scene scene = [] {
    Outcome<TomlFile> file = TomlFile::parse(default_scene_text(), "built-in scene");
    assert(file);
    Outcome<Scene> made = scene_of(*file, Scene{});
    assert(made);
    return std::move(made).value();
  }();
  return scene;
}

Outcome<Scene> parse_scene(std::string_view text, const std::string& name) {
  const Outcome<TomlFile> file = TomlFile::parse(text, name);
  if (!file) return file.error();
  return scene_of(*file, default_scene());
}

Outcome<Scene> read_scene(const std::filesystem::path& path) {
  const Outcome<TomlFile> file = TomlFile::load(path);
  if (!file) return file.error();
  return scene_of(*file, default_scene());
}

}  // namespace srd
