#include "drivers/recording/truth.hpp"

#include <span>
#include <string>

#include "drivers/support/text_file.hpp"

namespace srd {

Outcome<Truth> read_truth(const std::filesystem::path& file) {
  const std::string expected = "frame,time_ns,<modes>";
  const Outcome<std::string> text = read_text_file(file, "a truth file: " + expected, std::size_t{1} << 28);
  if (!text) return text.error();
  const std::vector<TextLine> lines = split_lines(*text);
  const auto problem = [&](int line, const std::string& what, const std::string& wanted,
                           std::string_view found) {
    return Problem{Exit::kInput,
                   what,
                   file.string() + ":" + std::to_string(line),
                   wanted,
                   "'" + std::string(found.substr(0, 80)) + "'",
                   ""};
  };
  if (lines.empty()) return problem(1, "has no header", expected, "");
  const std::vector<std::string_view> header = split_commas(lines[0].text);
  if (header.size() < 3 || header[0] != "frame" || header[1] != "time_ns")
    return problem(1, "has another header", expected, lines[0].text);
  std::vector<dsp::Mode> modes;
  for (std::size_t i = 2; i < header.size(); ++i) {
    const std::optional<dsp::Mode> mode = dsp::Mode::parse(header[i]);
    if (!mode) return problem(1, "names no mode", "A00, B, C, A10, ..", header[i]);
    modes.push_back(*mode);
  }
  const Result<dsp::ModeList> list = dsp::ModeList::make(modes);
  if (!list) return problem(1, "is no list of modes", "up to 24 different modes", lines[0].text);
  Truth truth{*list, {}};
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const TextLine& line = lines[i];
    if (trimmed(line.text).empty()) continue;
    const std::vector<std::string_view> fields = split_commas(line.text);
    const std::string wanted = std::to_string(header.size()) + " numbers: " + std::string(lines[0].text);
    if (fields.size() != header.size()) return problem(line.number, "has another length", wanted, line.text);
    const auto frame = parse_number<std::uint64_t>(fields[0]);
    const auto time_ns = parse_number<std::int64_t>(fields[1]);
    if (!frame || !time_ns) return problem(line.number, "is not a row of truth", wanted, line.text);
    TruthRow row{*frame, *time_ns, dsp::Coefficients<double>(list->size())};
    for (int j = 0; j < list->size(); ++j) {
      const auto value = parse_number<double>(fields[static_cast<std::size_t>(j) + 2]);
      if (!value) return problem(line.number, "is not a row of truth", wanted, line.text);
      row.coefficients[j] = *value;
    }
    truth.rows.push_back(row);
  }
  return truth;
}

Outcome<void> write_truth(const std::filesystem::path& file, const Truth& truth) {
  std::string text = "frame,time_ns";
  for (const dsp::Mode& mode : truth.modes) text += "," + std::string(mode.name().data());
  text += "\n";
  for (const TruthRow& row : truth.rows) {
    text += std::to_string(row.frame) + "," + std::to_string(row.time_ns);
    for (const double a : row.coefficients) text += "," + number_text(a);
    text += "\n";
  }
  return write_text_file(file, text);
}

}  // namespace srd
