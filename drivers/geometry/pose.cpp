// SPDX-License-Identifier: Apache-2.0
#include "drivers/geometry/pose.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <opencv2/core.hpp>

#include "drivers/geometry/opencv_storage.hpp"
#include "drivers/support/limits.hpp"
#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

namespace fs = std::filesystem;

Outcome<dsp::Pose<double>> pose_of(const cv::FileNode& root, const fs::path& file) {
  const std::string kRotationKey = "Rotationmatrix", kTranslationKey = "TranslationVector";
  const std::string expected = "a 3 x 3 rotation: orthonormal to 1e-3, determinant +1";
  MatrixShape shape;
  const Outcome<std::vector<double>> r = read_matrix(root, file, kRotationKey, expected, &shape);
  if (!r) return r.error();
  if (shape.rows != 3 || shape.columns != 3)
    return wrong_key(file, kRotationKey, expected, std::to_string(shape.rows) + " x " + std::to_string(shape.columns));
  const dsp::Mat3<double> given = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(r->data());
  const double off = (given * given.transpose() - dsp::Mat3<double>::Identity()).cwiseAbs().maxCoeff();
  const double determinant = given.determinant();
  if (!(off <= 1e-3) || !(determinant > 0))
    return wrong_key(file, kRotationKey, expected,
                     "|R R' - I| = " + number_text(off) + ", determinant " + number_text(determinant));
  const std::string lengths = "3 numbers (mm) in one row or column";
  const Outcome<std::vector<double>> t = read_matrix(root, file, kTranslationKey, lengths, &shape);
  if (!t) return t.error();
  if (t->size() != 3 || (shape.rows != 1 && shape.columns != 1))
    return wrong_key(file, kTranslationKey, lengths, std::to_string(shape.rows) + " x " + std::to_string(shape.columns));
  for (const double x : *t)
    if (std::abs(x) > kMaxMm) return wrong_key(file, kTranslationKey, lengths + ", each within 1 km", list_text(*t));
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

constexpr const char* kCovarianceKey = "pose_covariance";

void put_pose(cv::FileStorage& storage, const dsp::Pose<double>& pose) {
  cv::Matx33d rotation;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) rotation(row, column) = pose.rotation(row, column);
  const dsp::Vec3<double>& t = pose.translation;
  storage << "Rotationmatrix" << cv::Mat(rotation);
  storage << "TranslationVector" << cv::Mat(cv::Matx31d(t.x(), t.y(), t.z()));
}

Outcome<std::optional<PoseCovariance>> covariance_of(const cv::FileNode& root, const fs::path& file) {
  using Found = std::optional<PoseCovariance>;
  if (root[kCovarianceKey].empty()) return Found{};
  const std::string expected = "6 x 6, symmetric, no negative variance";
  MatrixShape shape;
  const auto numbers = read_matrix(root, file, kCovarianceKey, expected, &shape);
  if (!numbers) return numbers.error();
  if (shape.rows != 6 || shape.columns != 6)
    return wrong_key(file, kCovarianceKey, expected, std::to_string(shape.rows) + " x " + std::to_string(shape.columns));
  const PoseCovariance given = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(numbers->data());
  for (int row = 0; row < 6; ++row) {
    if (!(given(row, row) >= 0)) return wrong_key(file, kCovarianceKey, expected, "variance " + number_text(given(row, row)));
    for (int column = 0; column < row; ++column)
      if (!(std::abs(given(row, column) - given(column, row)) <= 1e-6 * std::sqrt(given(row, row) * given(column, column))))
        return wrong_key(file, kCovarianceKey, expected, "entries that differ across the diagonal");
  }
  return Found{(given + given.transpose()) / 2};
}

}  // namespace

Outcome<dsp::Pose<double>> read_pose(const fs::path& file) {
  return read_storage_as<dsp::Pose<double>>(file, "a camera pose",
                                            [&](const cv::FileNode& root) { return pose_of(root, file); });
}

Outcome<void> write_pose(const fs::path& file, const dsp::Pose<double>& pose) {
  return write_storage(file, [&](cv::FileStorage& storage) { put_pose(storage, pose); });
}

Outcome<void> write_pose(const fs::path& file, const dsp::Pose<double>& pose, const PoseCovariance& covariance) {
  return write_storage(file, [&](cv::FileStorage& storage) {
    put_pose(storage, pose);
    cv::Matx<double, 6, 6> numbers;
    for (int row = 0; row < 6; ++row)
      for (int column = 0; column < 6; ++column) numbers(row, column) = covariance(row, column);
    storage << kCovarianceKey << cv::Mat(numbers);
  });
}

Outcome<std::optional<PoseCovariance>> read_pose_covariance(const fs::path& file) {
  return read_storage_as<std::optional<PoseCovariance>>(file, "a camera pose",
                                                        [&](const cv::FileNode& root) { return covariance_of(root, file); });
}

}  // namespace srd
