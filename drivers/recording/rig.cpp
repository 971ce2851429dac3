// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording/rig.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>

#include "drivers/recording/lens_model.hpp"
#include "drivers/recording/limits.hpp"
#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = std::size_t{1} << 22;
constexpr int kDeepest = 16;  // of brackets: OpenCV's parser recurses on them
constexpr double kMostPixels = 1e6;

Problem wrong(const fs::path& file, const std::string& key, const std::string& expected, const std::string& found,
              const std::string& advice = {}) {
  return {Exit::kInput, "key '" + key + "'", file.string(), expected, found, advice};
}

std::string list_text(const std::vector<double>& numbers) {
  std::string text = "[";
  for (const double x : numbers) text += (text.size() > 1 ? ", " : "") + number_text(x);
  return text + "]";
}

bool too_deep(const std::string& text) {
  int depth = 0;
  for (const char c : text) {
    if (c == '[' || c == '{') ++depth;
    if ((c == ']' || c == '}') && depth > 0) --depth;
    if (depth > kDeepest) return true;
  }
  return false;
}

// An OpenCV file (YAML, XML or JSON), read through a function that may throw OpenCV's exceptions.
template <class T, class Read>
Outcome<T> with_storage(const fs::path& file, const std::string& expected, Read read) {
  Outcome<std::string> text = read_text_file(file, expected, kMostBytes);
  if (!text) return text.error();
  const std::string advice = "write the file with 'srd calibrate' or with OpenCV's FileStorage";
  const std::string contents = expected + " of OpenCV FileStorage, beginning with %YAML, <?xml or {";
  if (text->find('\0') != std::string::npos || too_deep(*text))
    return Problem{Exit::kInput, "is not " + expected, file.string(), contents, "other contents", advice};
  try {
    const cv::FileStorage storage(*text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    if (!storage.isOpened() || !storage.root().isMap())
      return Problem{Exit::kInput, "is not " + expected, file.string(), contents, "other contents", advice};
    return read(storage.root());
  } catch (const cv::Exception& exception) {
    return Problem{Exit::kInput, "cannot be understood", file.string(), contents, exception.err, advice};
  } catch (const std::exception& exception) {
    return Problem{Exit::kInput, "cannot be understood", file.string(), contents, exception.what(), advice};
  }
}

struct Shape {
  int rows = 0, columns = 0;
};

// A matrix of finite numbers, row by row. The counts are compared with the list before anything is reserved.
Outcome<std::vector<double>> matrix(const cv::FileNode& root, const fs::path& file, const std::string& key,
                                    const std::string& expected, Shape* shape = nullptr) {
  const cv::FileNode node = root[key];
  if (node.empty()) return wrong(file, key, expected, "no such key");
  if (!node.isMap()) return wrong(file, key, expected, "something that is not a matrix");
  const cv::FileNode rows = node["rows"], columns = node["cols"], list = node["data"];
  if (!rows.isInt() || !columns.isInt() || !list.isSeq())
    return wrong(file, key, expected, "a matrix without rows, cols or data");
  const int n_rows = static_cast<int>(rows), n_columns = static_cast<int>(columns);
  const std::size_t count = list.size();
  if (n_rows < 1 || n_columns < 1 || n_rows > 64 || n_columns > 64 || static_cast<std::size_t>(n_rows * n_columns) != count)
    return wrong(file, key, expected,
                 std::to_string(n_rows) + " x " + std::to_string(n_columns) + " with " + std::to_string(count) + " numbers");
  std::vector<double> numbers;
  for (const cv::FileNode& element : list) {
    const double x = element.isInt() || element.isReal() ? element.real() : std::nan("");
    if (!std::isfinite(x))
      return wrong(file, key, expected, "entry " + std::to_string(numbers.size()) + " is not a finite number");
    numbers.push_back(x);
  }
  if (shape != nullptr) *shape = {n_rows, n_columns};
  return numbers;
}

Outcome<int> image_side(const cv::FileNode& root, const fs::path& file, const std::string& key) {
  const cv::FileNode node = root[key];
  if (node.empty()) return 0;
  const std::string expected = "a whole number of px from 1 to 1000000";
  if (!node.isInt()) return wrong(file, key, expected, "something else");
  const int side = static_cast<int>(node);
  if (side < 1 || side > static_cast<int>(kMostPixels)) return wrong(file, key, expected, std::to_string(side));
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
    if (refusal.refused()) return wrong(file, key, refusal.expected, refusal.found, advice);
  }
  if (!root["xi"].empty())
    return wrong(file, "xi", "no such key: OpenCV's pinhole lens", "the mirror parameter of an omnidirectional camera", advice);
  return {};
}

Outcome<Calibration> calibration_of(const cv::FileNode& root, const fs::path& file) {
  const std::string kKey = "camera_matrix", kDistortionKey = "distortion_coefficients";
  const std::string expected = "3 x 3: [fx, 0, cx, 0, fy, cy, 0, 0, 1] with fx, fy > 0 (px)";
  Shape shape;
  const Outcome<std::vector<double>> k = matrix(root, file, kKey, expected, &shape);
  if (!k) return k.error();
  if (shape.rows != 3 || shape.columns != 3)
    return wrong(file, kKey, expected, std::to_string(shape.rows) + " x " + std::to_string(shape.columns));
  const std::vector<double>& m = *k;
  const bool pinhole = m[1] == 0 && m[3] == 0 && m[6] == 0 && m[7] == 0 && m[8] == 1;
  if (!pinhole || !(m[0] > 0) || !(m[4] > 0) || std::max({m[0], m[4], std::abs(m[2]), std::abs(m[5])}) > kMostPixels)
    return wrong(file, kKey, expected, list_text(m));

  Calibration calibration;
  if (!root[kDistortionKey].empty()) {
    const std::string counts = "4, 5, 8, 12 or 14 numbers in one row or column";
    const Outcome<std::vector<double>> d = matrix(root, file, kDistortionKey, counts, &shape);
    if (!d) return d.error();
    const std::size_t n = d->size();
    if ((shape.rows != 1 && shape.columns != 1) || (n != 4 && n != 5 && n != 8 && n != 12 && n != 14))
      return wrong(file, kDistortionKey, counts, std::to_string(shape.rows) + " x " + std::to_string(shape.columns));
    if (auto lens = check_lens(root, file, n); !lens) return lens.error();
    calibration.distortion = *d;
  } else {
    return wrong(file, kDistortionKey, "4, 5, 8, 12 or 14 numbers", "no such key",
                 "give four zeros for a lens without distortion");
  }
  const Outcome<int> width = image_side(root, file, "image_width"), height = image_side(root, file, "image_height");
  if (!width) return width.error();
  if (!height) return height.error();
  calibration.image_width = *width;
  calibration.image_height = *height;
  const auto camera = dsp::CameraModel<double>::make(m[0], m[4], m[2], m[5], calibration.distortion);
  if (!camera) return wrong(file, kKey, expected, list_text(m));
  calibration.camera = *camera;
  return calibration;
}

Outcome<dsp::Pose<double>> pose_of(const cv::FileNode& root, const fs::path& file) {
  const std::string kRotationKey = "Rotationmatrix", kTranslationKey = "TranslationVector";
  const std::string expected = "a 3 x 3 rotation: orthonormal to 1e-3, determinant +1";
  Shape shape;
  const Outcome<std::vector<double>> r = matrix(root, file, kRotationKey, expected, &shape);
  if (!r) return r.error();
  if (shape.rows != 3 || shape.columns != 3)
    return wrong(file, kRotationKey, expected, std::to_string(shape.rows) + " x " + std::to_string(shape.columns));
  const dsp::Mat3<double> given = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(r->data());
  const double off = (given * given.transpose() - dsp::Mat3<double>::Identity()).cwiseAbs().maxCoeff();
  const double determinant = given.determinant();
  if (!(off <= 1e-3) || !(determinant > 0))
    return wrong(file, kRotationKey, expected,
                 "|R R' - I| = " + number_text(off) + ", determinant " + number_text(determinant));
  const std::string lengths = "3 numbers (mm) in one row or column";
  const Outcome<std::vector<double>> t = matrix(root, file, kTranslationKey, lengths, &shape);
  if (!t) return t.error();
  if (t->size() != 3 || (shape.rows != 1 && shape.columns != 1))
    return wrong(file, kTranslationKey, lengths, std::to_string(shape.rows) + " x " + std::to_string(shape.columns));
  for (const double x : *t)
    if (std::abs(x) > kMostMm) return wrong(file, kTranslationKey, lengths + ", each within 1 km", list_text(*t));
  dsp::Pose<double> pose;
  pose.translation = Eigen::Map<const dsp::Vec3<double>>(t->data());
  // A matrix that is a rotation to the last bits keeps them: writing and reading gives the same numbers.
  if (off <= 1e-14) {
    pose.rotation = given;
  } else {
    const Eigen::JacobiSVD<dsp::Mat3<double>> svd(given, Eigen::ComputeFullU | Eigen::ComputeFullV);
    pose.rotation = svd.matrixU() * svd.matrixV().transpose();
  }
  return pose;
}

// What write puts into a FileStorage, in the file.
template <class Write>
Outcome<void> store(const fs::path& file, Write write) {
  try {
    cv::FileStorage storage("", cv::FileStorage::WRITE | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML);
    write(storage);
    return write_text_file(file, storage.releaseAndGetString());
  } catch (const std::exception& exception) {
    return Problem{Exit::kInput, "cannot be written", file.string(), "", exception.what(), ""};
  }
}

}  // namespace

Outcome<Calibration> read_calibration(const fs::path& file) {
  return with_storage<Calibration>(file, "a camera calibration",
                                   [&](const cv::FileNode& root) { return calibration_of(root, file); });
}

Outcome<void> write_calibration(const fs::path& file, const Calibration& calibration) {
  const dsp::CameraModel<double>& camera = calibration.camera;
  return store(file, [&](cv::FileStorage& storage) {
    if (calibration.image_width > 0) storage << "image_width" << calibration.image_width;
    if (calibration.image_height > 0) storage << "image_height" << calibration.image_height;
    storage << "camera_matrix" << cv::Mat(cv::Matx33d(camera.fx(), 0, camera.cx(), 0, camera.fy(), camera.cy(), 0, 0, 1));
    std::vector<double> distortion = calibration.distortion;
    if (distortion.empty()) distortion.assign(camera.distortion().begin(), camera.distortion().end());
    storage << "distortion_coefficients" << cv::Mat(distortion);
  });
}

Outcome<dsp::Pose<double>> read_pose(const fs::path& file) {
  return with_storage<dsp::Pose<double>>(file, "a camera pose", [&](const cv::FileNode& root) { return pose_of(root, file); });
}

Outcome<void> write_pose(const fs::path& file, const dsp::Pose<double>& pose) {
  return store(file, [&](cv::FileStorage& storage) {
    cv::Matx33d rotation;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) rotation(row, column) = pose.rotation(row, column);
    const dsp::Vec3<double>& t = pose.translation;
    storage << "Rotationmatrix" << cv::Mat(rotation);
    storage << "TranslationVector" << cv::Mat(cv::Matx31d(t.x(), t.y(), t.z()));
  });
}

Outcome<Points> read_points(const fs::path& file) {
  const std::string expected = "x y z (mm) a line";
  const Outcome<std::string> text = read_text_file(file, "points: " + expected);
  if (!text) return text.error();
  Points points;
  std::map<std::array<double, 3>, int> seen;
  for (const TextLine& line : split_lines(*text)) {
    const std::string_view content = trimmed(line.text.substr(0, line.text.find('#')));
    if (content.empty()) continue;
    const std::string where = file.string() + ":" + std::to_string(line.number);
    const std::vector<std::string_view> fields = split_blanks(content);
    std::array<double, 3> xyz{};
    bool good = fields.size() == 3;
    for (std::size_t i = 0; good && i < 3; ++i) {
      const std::optional<double> x = parse_number<double>(fields[i]);
      good = x && std::abs(*x) <= kMostMm;
      if (good) xyz[i] = *x + 0.0;  // -0 and 0 are one place
    }
    if (!good)
      return Problem{Exit::kInput,
                     "is not a point",
                     where,
                     expected + ", each within 1 km",
                     "'" + std::string(content.substr(0, 60)) + "'",
                     ""};
    const auto [earlier, is_new] = seen.emplace(xyz, line.number);
    if (!is_new)
      return Problem{Exit::kInput,
                     "repeats a point",
                     where,
                     "every point once",
                     "the same numbers in line " + std::to_string(earlier->second),
                     "delete one of the lines"};
    points.emplace_back(xyz[0], xyz[1], xyz[2]);
  }
  if (points.empty())
    return Problem{Exit::kInput, "holds no points", file.string(), expected, text->empty() ? "an empty file" : "", ""};
  return points;
}

Outcome<void> write_points(const fs::path& file, const Points& points) {
  std::string text;
  for (const auto& p : points) text += number_text(p.x()) + " " + number_text(p.y()) + " " + number_text(p.z()) + "\n";
  return write_text_file(file, text);
}

}  // namespace srd
