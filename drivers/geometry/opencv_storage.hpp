// SPDX-License-Identifier: Apache-2.0
// Files of OpenCV's FileStorage (YAML, XML or JSON), read with every value checked and its exceptions turned into Problems.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <opencv2/core/persistence.hpp>
#include <string>
#include <utility>
#include <vector>

#include "drivers/support/day.hpp"
#include "drivers/support/problem.hpp"

namespace srd {

// kInput: the key of the file is missing or wrong.
[[nodiscard]] Problem wrong_key(const std::filesystem::path& file, const std::string& key, const std::string& expected,
                                const std::string& found, const std::string& advice = {});
// "[1, 2.5, 3]"
[[nodiscard]] std::string list_text(const std::vector<double>& numbers);

// The file's map, given to read, which may throw OpenCV's exceptions. kInput when the file is not readable, not a
// FileStorage, larger than 4 MiB or nested too deep. expected: what the file should be, "a camera pose".
[[nodiscard]] Outcome<void> read_storage(const std::filesystem::path& file, const std::string& expected,
                                         const std::function<Outcome<void>(const cv::FileNode& root)>& read);
// The same for what read makes of the map.
template <class T>
[[nodiscard]] Outcome<T> read_storage_as(const std::filesystem::path& file, const std::string& expected,
                                         const std::function<Outcome<T>(const cv::FileNode& root)>& read) {
  T value;
  const Outcome<void> done = read_storage(file, expected, [&](const cv::FileNode& root) -> Outcome<void> {
    Outcome<T> made = read(root);
    if (!made) return made.error();
    value = std::move(*made);
    return {};
  });
  if (!done) return done.error();
  return value;
}
// What write puts into a FileStorage, as YAML in the file.
[[nodiscard]] Outcome<void> write_storage(const std::filesystem::path& file,
                                          const std::function<void(cv::FileStorage& storage)>& write);

struct MatrixShape {
  int rows = 0, columns = 0;
};

// A matrix of finite numbers, row by row, of at most 64 x 64. The counts are compared with the list before anything is
// reserved.
[[nodiscard]] Outcome<std::vector<double>> read_matrix(const cv::FileNode& root, const std::filesystem::path& file,
                                                       const std::string& key, const std::string& expected,
                                                       MatrixShape* shape = nullptr);

// A covariance: size x size, symmetric to 1e-6 of the deviations' product, no negative variance.
[[nodiscard]] Outcome<Eigen::MatrixXd> read_covariance(const cv::FileNode& root, const std::filesystem::path& file,
                                                       const std::string& key, int size);
void put_matrix(cv::FileStorage& storage, const std::string& key, const Eigen::MatrixXd& matrix);
// 0 where the file has none.
[[nodiscard]] Outcome<Day> read_date(const cv::FileNode& root, const std::filesystem::path& file, const std::string& key);

}  // namespace srd
