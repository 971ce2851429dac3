// SPDX-License-Identifier: Apache-2.0
#include "drivers/geometry/points.hpp"

#include <array>
#include <cmath>
#include <map>

#include "drivers/support/limits.hpp"
#include "drivers/support/text_file.hpp"

namespace srd {

namespace fs = std::filesystem;

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
      good = x && std::abs(*x) <= kMaxMm;
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
