// SPDX-License-Identifier: Apache-2.0
#include "host/listen/frames_in_file.hpp"

#include <fstream>
#include <string>

#include "drivers/support/text_file.hpp"
#include "host/coefficients/row_writer.hpp"

namespace srd::host {
namespace {

// Takes the cell in front off the line.
std::string_view take_cell(std::string_view& line) {
  const std::string_view cell = line.substr(0, line.find(','));
  line.remove_prefix(std::min(line.size(), cell.size() + 1));
  return cell;
}

}  // namespace

Outcome<FramesInFile> read_frames_in_file(const std::filesystem::path& file) {
  FramesInFile out;
  std::ifstream in(file, std::ios::binary);
  if (!in) return Problem{.what = "cannot read the file", .where = file.string()};
  const auto not_ours = [&](std::uint64_t line, std::string found) {
    return Problem{.what = "not a record of srd listen",
                   .where = file.string() + ":" + std::to_string(line),
                   .expected = line == 1 ? "node,boot,sequence,time_ns,..,A00,..,sd_A00,.." : "node,boot,sequence,..",
                   .found = "'" + found.substr(0, 80) + "'",
                   .advice =
                       "another name, or --force to write the file anew: records of earlier versions and files that another "
                       "program saved again are read, and not gone on with"};
  };
  std::uint64_t number = 0;
  for (std::string text; std::getline(in, text);) {
    const bool whole = !in.eof();  // the last line has its end
    ++number;
    if (!whole && number > 1) break;
    if (number == 1) {
      out.modes = whole ? modes_of_header(text) : std::nullopt;
      // A header cut short is the beginning of one.
      const bool torn = !whole && (text.starts_with("node,boot,") || std::string_view("node,boot,").starts_with(text));
      if (!out.modes && !torn) return not_ours(1, text);
      if (torn) break;
    } else {
      std::string_view line = text;
      const auto node = proto::NodeId::make(take_cell(line));
      const auto boot = parse_boot(take_cell(line));
      const auto sequence = parse_number<std::uint64_t>(take_cell(line));
      if (!node || !boot || !sequence || *sequence >= proto::kMaxSequence) return not_ours(number, text);
      out.frames[{*node, *boot}].add(*sequence);
      ++out.rows;
    }
    out.whole_bytes += text.size() + 1;
  }
  return out;
}

}  // namespace srd::host
