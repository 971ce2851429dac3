// SPDX-License-Identifier: Apache-2.0
#include "drivers/geometry/opencv_storage.hpp"

#include <cmath>
#include <opencv2/core.hpp>

#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxBytes = std::size_t{1} << 22;
constexpr int kDeepest = 16;  // of brackets: OpenCV's parser recurses on them

bool too_deep(const std::string& text) {
  int depth = 0;
  for (const char c : text) {
    if (c == '[' || c == '{') ++depth;
    if ((c == ']' || c == '}') && depth > 0) --depth;
    if (depth > kDeepest) return true;
  }
  return false;
}

}  // namespace

Problem wrong_key(const fs::path& file, const std::string& key, const std::string& expected, const std::string& found,
                  const std::string& advice) {
  return {Exit::kInput, "key '" + key + "'", file.string(), expected, found, advice};
}

std::string list_text(const std::vector<double>& numbers) {
  std::string text = "[";
  for (const double x : numbers) text += (text.size() > 1 ? ", " : "") + number_text(x);
  return text + "]";
}

Outcome<void> read_storage(const fs::path& file, const std::string& expected,
                           const std::function<Outcome<void>(const cv::FileNode& root)>& read) {
  Outcome<std::string> text = read_text_file(file, expected, kMaxBytes);
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

Outcome<void> write_storage(const fs::path& file, const std::function<void(cv::FileStorage& storage)>& write) {
  try {
    cv::FileStorage storage("", cv::FileStorage::WRITE | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML);
    write(storage);
    return write_text_file(file, storage.releaseAndGetString());
  } catch (const std::exception& exception) {
    return Problem{Exit::kInput, "cannot be written", file.string(), "", exception.what(), ""};
  }
}

Outcome<std::vector<double>> read_matrix(const cv::FileNode& root, const fs::path& file, const std::string& key,
                                         const std::string& expected, MatrixShape* shape) {
  const cv::FileNode node = root[key];
  if (node.empty()) return wrong_key(file, key, expected, "no such key");
  if (!node.isMap()) return wrong_key(file, key, expected, "something that is not a matrix");
  const cv::FileNode rows = node["rows"], columns = node["cols"], list = node["data"];
  if (!rows.isInt() || !columns.isInt() || !list.isSeq())
    return wrong_key(file, key, expected, "a matrix without rows, cols or data");
  const int n_rows = static_cast<int>(rows), n_columns = static_cast<int>(columns);
  const std::size_t count = list.size();
  if (n_rows < 1 || n_columns < 1 || n_rows > 64 || n_columns > 64 || static_cast<std::size_t>(n_rows * n_columns) != count)
    return wrong_key(
        file, key, expected,
        std::to_string(n_rows) + " x " + std::to_string(n_columns) + " with " + std::to_string(count) + " numbers");
  std::vector<double> numbers;
  for (const cv::FileNode& element : list) {
    const double x = element.isInt() || element.isReal() ? element.real() : std::nan("");
    if (!std::isfinite(x))
      return wrong_key(file, key, expected, "entry " + std::to_string(numbers.size()) + " is not a finite number");
    numbers.push_back(x);
  }
  if (shape != nullptr) *shape = {n_rows, n_columns};
  return numbers;
}

Outcome<Eigen::MatrixXd> read_covariance(const cv::FileNode& root, const std::filesystem::path& file, const std::string& key,
                                         int size) {
  const std::string expected = std::to_string(size) + " x " + std::to_string(size) + ", symmetric, no negative variance";
  MatrixShape shape;
  const auto numbers = read_matrix(root, file, key, expected, &shape);
  if (!numbers) return numbers.error();
  if (shape.rows != size || shape.columns != size)
    return wrong_key(file, key, expected, std::to_string(shape.rows) + " x " + std::to_string(shape.columns));
  const Eigen::MatrixXd given =
      Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(numbers->data(), size, size);
  for (int row = 0; row < size; ++row) {
    if (!(given(row, row) >= 0)) return wrong_key(file, key, expected, "variance " + number_text(given(row, row)));
    for (int column = 0; column < row; ++column)
      if (!(std::abs(given(row, column) - given(column, row)) <= 1e-6 * std::sqrt(given(row, row) * given(column, column))))
        return wrong_key(file, key, expected, "entries that differ across the diagonal");
  }
  return Eigen::MatrixXd((given + given.transpose()) / 2);
}

void put_matrix(cv::FileStorage& storage, const std::string& key, const Eigen::MatrixXd& matrix) {
  cv::Mat numbers(static_cast<int>(matrix.rows()), static_cast<int>(matrix.cols()), CV_64F);
  for (int row = 0; row < numbers.rows; ++row)
    for (int column = 0; column < numbers.cols; ++column) numbers.at<double>(row, column) = matrix(row, column);
  storage << key << numbers;
}

Outcome<Day> read_date(const cv::FileNode& root, const std::filesystem::path& file, const std::string& key) {
  const cv::FileNode node = root[key];
  if (node.empty()) return Day{0};
  const std::string text = node.isString() ? static_cast<std::string>(node) : "something that is no text";
  const auto day = parse_day(text);
  if (!day) return wrong_key(file, key, "a date as 2026-11-28", text);
  return *day;
}

}  // namespace srd
