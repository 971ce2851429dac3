// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording/truth.hpp"

#include <cmath>
#include <string>

#include "drivers/support/csv_table.hpp"
#include "drivers/support/mode_names.hpp"
#include "drivers/support/text_file.hpp"

namespace srd {

Outcome<Truth> read_truth(const std::filesystem::path& file) {
  const std::string expected = "frame,time_ns,<modes>";
  Outcome<std::string> text = read_text_file(file, "a truth file: " + expected, std::size_t{1} << 28);
  if (!text) return text.error();
  if (!text->empty() && text->back() != '\n') *text += '\n';  // as editors leave it
  const auto header_problem = [&](const std::string& what, const std::string& wanted, const std::string& found) {
    return Problem{Exit::kInput, what, file.string() + ":1", wanted, "'" + found.substr(0, 80) + "'", ""};
  };
  if (text->empty()) return header_problem("has no header", expected, "");
  const Outcome<CsvTable> table = CsvTable::parse(std::move(*text), file.string());
  if (!table) return table.error();
  const std::vector<std::string>& header = table->columns();
  std::string names;
  for (const std::string& name : header) names += (names.empty() ? "" : ",") + name;
  if (header.size() < 3 || header[0] != "frame" || header[1] != "time_ns")
    return header_problem("has another header", expected, names);
  std::vector<dsp::Mode> modes;
  for (std::size_t i = 2; i < header.size(); ++i) {
    const std::optional<dsp::Mode> mode = dsp::Mode::parse(header[i]);
    if (!mode) return header_problem("names no mode", "A00, B, C, A10, ..", header[i]);
    modes.push_back(*mode);
  }
  const Result<dsp::ModeList> list = dsp::ModeList::make(modes);
  if (!list) return header_problem("is no list of modes", "up to 24 different modes", names);
  const auto frames = table->unsigned_integers("frame");
  if (!frames) return frames.error();
  const auto times = table->integers("time_ns");
  if (!times) return times.error();
  Truth truth{*list, {}};
  for (std::size_t i = 0; i < table->rows(); ++i)
    truth.rows.push_back({(*frames)[i], (*times)[i], dsp::Coefficients<double>(list->size())});
  for (int j = 0; j < list->size(); ++j) {
    const auto values = table->numbers(header[static_cast<std::size_t>(j) + 2]);
    if (!values) return values.error();
    for (std::size_t i = 0; i < table->rows(); ++i) {
      if (std::isnan((*values)[i]))
        return Problem{Exit::kInput,
                       "is not a row of truth",
                       table->where(i),
                       std::to_string(header.size()) + " numbers: " + names,
                       "nothing in column '" + header[static_cast<std::size_t>(j) + 2] + "'",
                       ""};
      truth.rows[i].coefficients[j] = (*values)[i];
    }
  }
  return truth;
}

Outcome<void> write_truth(const std::filesystem::path& file, const Truth& truth) {
  std::string text = "frame,time_ns," + joined(truth.modes, ",") + "\n";
  for (const TruthRow& row : truth.rows) {
    text += std::to_string(row.frame) + "," + std::to_string(row.time_ns);
    for (const double a : row.coefficients) text += "," + number_text(a);
    text += "\n";
  }
  return write_text_file(file, text);
}

}  // namespace srd
