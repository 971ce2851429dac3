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

constexpr const char* kPoseCovarianceKey = "pose_covariance";
constexpr const char* kByCalibrationKey = "pose_by_calibration";
constexpr const char* kPoseDateKey = "pose_date";

void put_pose(cv::FileStorage& storage, const dsp::Pose<double>& pose) {
  cv::Matx33d rotation;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) rotation(row, column) = pose.rotation(row, column);
  const dsp::Vec3<double>& t = pose.translation;
  storage << "Rotationmatrix" << cv::Mat(rotation);
  storage << "TranslationVector" << cv::Mat(cv::Matx31d(t.x(), t.y(), t.z()));
}

Outcome<std::optional<PoseErrors>> errors_of(const cv::FileNode& root, const fs::path& file) {
  using Found = std::optional<PoseErrors>;
  if (root[kPoseCovarianceKey].empty()) return Found{};
  PoseErrors errors;
  const auto covariance = read_covariance(root, file, kPoseCovarianceKey, 6);
  if (!covariance) return covariance.error();
  errors.covariance = *covariance;
  const auto date = read_date(root, file, kPoseDateKey);
  if (!date) return date.error();
  errors.date = *date;
  if (root[kByCalibrationKey].empty()) return Found{errors};
  const std::string expected = "6 x " + std::to_string(dsp::kMaxIntrinsics) + ": of turn and shift by fx fy cx cy k1 .. ty";
  MatrixShape shape;
  const auto numbers = read_matrix(root, file, kByCalibrationKey, expected, &shape);
  if (!numbers) return numbers.error();
  if (shape.rows != 6 || shape.columns != dsp::kMaxIntrinsics)
    return wrong_key(file, kByCalibrationKey, expected, std::to_string(shape.rows) + " x " + std::to_string(shape.columns));
  errors.by_calibration = Eigen::Map<const Eigen::Matrix<double, 6, dsp::kMaxIntrinsics, Eigen::RowMajor>>(numbers->data());
  return Found{errors};
}

}  // namespace

Outcome<dsp::Pose<double>> read_pose(const fs::path& file) {
  return read_storage_as<dsp::Pose<double>>(file, "a camera pose",
                                            [&](const cv::FileNode& root) { return pose_of(root, file); });
}

Outcome<void> write_pose(const fs::path& file, const dsp::Pose<double>& pose, const std::optional<PoseErrors>& errors) {
  return write_storage(file, [&](cv::FileStorage& storage) {
    put_pose(storage, pose);
    if (!errors) return;
    put_matrix(storage, kPoseCovarianceKey, errors->covariance);
    if (errors->by_calibration) put_matrix(storage, kByCalibrationKey, *errors->by_calibration);
    if (errors->date > 0) storage << kPoseDateKey << day_text(errors->date);
  });
}

Outcome<std::optional<PoseErrors>> read_pose_errors(const fs::path& file) {
  return read_storage_as<std::optional<PoseErrors>>(file, "a camera pose",
                                                    [&](const cv::FileNode& root) { return errors_of(root, file); });
}

}  // namespace srd
