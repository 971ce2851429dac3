// SPDX-License-Identifier: Apache-2.0
#include "host/run/features.hpp"

#include <array>
#include <cmath>
#include <cstdio>

#include "drivers/support/text_file.hpp"

namespace srd::host {

Outcome<std::vector<Feature>> read_features(const std::filesystem::path& file, int point_count) {
  constexpr double kMaxPixels = 1e5;
  const std::string expected = "id u v (undistorted px) a line";
  const Outcome<std::string> text = read_text_file(file, "features: " + expected);
  if (!text) return text.error();
  std::vector<Feature> features;
  std::vector<int> line_of(static_cast<std::size_t>(point_count), 0);
  for (const TextLine& line : split_lines(*text)) {
    const std::vector<std::string_view> fields = split_blanks(line.text);
    if (fields.empty()) continue;
    const std::string where = file.string() + ":" + std::to_string(line.number);
    const std::string shown = "'" + std::string(line.text.substr(0, 60)) + "'";
    if (fields.size() != 3) return Problem{Exit::kInput, "is not a feature", where, expected, shown, ""};
    const std::optional<int> id = parse_number<int>(fields[0]);
    const std::optional<double> u = parse_number<double>(fields[1]), v = parse_number<double>(fields[2]);
    if (!id || !u || !v || std::abs(*u) > kMaxPixels || std::abs(*v) > kMaxPixels)
      return Problem{Exit::kInput, "is not a feature", where, expected, shown, ""};
    if (*id < 0 || *id >= point_count)
      return Problem{Exit::kInput,
                     "names a feature that does not exist",
                     where,
                     "an id from 0 to " + std::to_string(point_count - 1) + ": a line of the feature points' file",
                     std::to_string(*id),
                     "check that features and points belong together"};
    int& earlier = line_of[static_cast<std::size_t>(*id)];
    if (earlier != 0)
      return Problem{Exit::kInput,
                     "names a feature twice",
                     where,
                     "every id once",
                     "id " + std::to_string(*id) + " in line " + std::to_string(earlier) + " too",
                     ""};
    earlier = line.number;
    features.push_back({*id, *u, *v});
  }
  return features;
}

Outcome<void> write_features(const std::filesystem::path& file, const std::vector<Feature>& features) {
  std::string text;
  for (const Feature& f : features) {
    std::array<char, 96> line;
    const int length = std::snprintf(line.data(), line.size(), "%d\t%.6f\t%.6f\n", f.id, f.u, f.v);
    text.append(line.data(), static_cast<std::size_t>(length));
  }
  return write_text_file(file, text);
}

}  // namespace srd::host
