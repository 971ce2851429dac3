// SPDX-License-Identifier: Apache-2.0
#include "drivers/geometry/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "drivers/geometry/lens_model.hpp"
#include "drivers/geometry/opencv_storage.hpp"
#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

namespace fs = std::filesystem;

constexpr double kMaxPixels = 1e6;

Outcome<int> image_side(const cv::FileNode& root, const fs::path& file, const std::string& key) {
  const cv::FileNode node = root[key];
  if (node.empty()) return 0;
  const std::string expected = "a whole number of px from 1 to 1000000";
  if (!node.isInt()) return wrong_key(file, key, expected, "something else");
  const int side = static_cast<int>(node);
  if (side < 1 || side > static_cast<int>(kMaxPixels)) return wrong_key(file, key, expected, std::to_string(side));
  return side;
}

// A key's value as it would be read aloud.
std::string scalar_text(const cv::FileNode& node) {
  if (node.isString()) return static_cast<std::string>(node);
  if (node.isInt() || node.isReal()) return number_text(node.real());
  return "something that is not a name";
}

// Four numbers say nothing of the formula that they belong to; where the file does, it must be ours.
Outcome<void> check_lens(const cv::FileNode& root, const fs::path& file, std::size_t n) {
  const std::string advice =
      "calibrate the camera for OpenCV's pinhole lens (calibrateCamera), not for a fisheye or an omnidirectional one";
  for (const char* key : {"distortion_model", "camera_model", "model_type", "fisheye_model"}) {
    if (root[key].empty()) continue;
    const LensRefusal refusal = check_lens_model(key, scalar_text(root[key]), n);
    if (refusal.refused()) return wrong_key(file, key, refusal.expected, refusal.found, advice);
  }
  if (!root["xi"].empty())
    return wrong_key(file, "xi", "no such key: OpenCV's pinhole lens", "the mirror parameter of an omnidirectional camera",
                     advice);
  return {};
}

constexpr const char* kCovarianceKey = "calibration_covariance";
constexpr const char* kDateKey = "calibration_date";

Outcome<std::optional<dsp::IntrinsicsMatrix>> covariance_of(const cv::FileNode& root, const fs::path& file, int size) {
  using Found = std::optional<dsp::IntrinsicsMatrix>;
  if (root[kCovarianceKey].empty()) return Found{};
  const auto numbers = read_covariance(root, file, kCovarianceKey, size);
  if (!numbers) return numbers.error();
  dsp::IntrinsicsMatrix covariance = dsp::IntrinsicsMatrix::Zero();
  covariance.topLeftCorner(size, size) = *numbers;
  return Found{covariance};
}

Outcome<Calibration> calibration_of(const cv::FileNode& root, const fs::path& file) {
  const std::string kKey = "camera_matrix", kDistortionKey = "distortion_coefficients";
  const std::string expected = "3 x 3: [fx, 0, cx, 0, fy, cy, 0, 0, 1] with fx, fy > 0 (px)";
  MatrixShape shape;
  const Outcome<std::vector<double>> k = read_matrix(root, file, kKey, expected, &shape);
  if (!k) return k.error();
  if (shape.rows != 3 || shape.columns != 3)
    return wrong_key(file, kKey, expected, std::to_string(shape.rows) + " x " + std::to_string(shape.columns));
  const std::vector<double>& m = *k;
  const bool pinhole = m[1] == 0 && m[3] == 0 && m[6] == 0 && m[7] == 0 && m[8] == 1;
  if (!pinhole || !(m[0] > 0) || !(m[4] > 0) || std::max({m[0], m[4], std::abs(m[2]), std::abs(m[5])}) > kMaxPixels)
    return wrong_key(file, kKey, expected, list_text(m));

  Calibration calibration;
  if (!root[kDistortionKey].empty()) {
    const std::string counts = "4, 5, 8, 12 or 14 numbers in one row or column";
    const Outcome<std::vector<double>> d = read_matrix(root, file, kDistortionKey, counts, &shape);
    if (!d) return d.error();
    const std::size_t n = d->size();
    if ((shape.rows != 1 && shape.columns != 1) || (n != 4 && n != 5 && n != 8 && n != 12 && n != 14))
      return wrong_key(file, kDistortionKey, counts, std::to_string(shape.rows) + " x " + std::to_string(shape.columns));
    if (auto lens = check_lens(root, file, n); !lens) return lens.error();
    calibration.distortion = *d;
  } else {
    return wrong_key(file, kDistortionKey, "4, 5, 8, 12 or 14 numbers", "no such key",
                     "give four zeros for a lens without distortion");
  }
  const Outcome<int> width = image_side(root, file, "image_width"), height = image_side(root, file, "image_height");
  if (!width) return width.error();
  if (!height) return height.error();
  calibration.image_width = *width;
  calibration.image_height = *height;
  const auto camera = dsp::CameraModel<double>::make(m[0], m[4], m[2], m[5], calibration.distortion);
  if (!camera) return wrong_key(file, kKey, expected, list_text(m));
  calibration.camera = *camera;
  const auto covariance = covariance_of(root, file, dsp::kPinhole + static_cast<int>(calibration.distortion.size()));
  if (!covariance) return covariance.error();
  calibration.covariance = *covariance;
  const auto date = read_date(root, file, kDateKey);
  if (!date) return date.error();
  calibration.date = *date;
  return calibration;
}

}  // namespace

Outcome<Calibration> read_calibration(const fs::path& file) {
  return read_storage_as<Calibration>(file, "a camera calibration",
                                      [&](const cv::FileNode& root) { return calibration_of(root, file); });
}

Outcome<void> write_calibration(const fs::path& file, const Calibration& calibration) {
  const dsp::CameraModel<double>& camera = calibration.camera;
  return write_storage(file, [&](cv::FileStorage& storage) {
    if (calibration.image_width > 0) storage << "image_width" << calibration.image_width;
    if (calibration.image_height > 0) storage << "image_height" << calibration.image_height;
    storage << "camera_matrix" << cv::Mat(cv::Matx33d(camera.fx(), 0, camera.cx(), 0, camera.fy(), camera.cy(), 0, 0, 1));
    std::vector<double> distortion = calibration.distortion;
    if (distortion.empty()) distortion.assign(camera.distortion().begin(), camera.distortion().end());
    storage << "distortion_coefficients" << cv::Mat(distortion);
    const int size = dsp::kPinhole + static_cast<int>(distortion.size());
    if (calibration.covariance) put_matrix(storage, kCovarianceKey, calibration.covariance->topLeftCorner(size, size));
    if (calibration.date > 0) storage << kDateKey << day_text(calibration.date);
  });
}

}  // namespace srd
