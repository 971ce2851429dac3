// SPDX-License-Identifier: Apache-2.0
#include "drivers/recording/recording.hpp"

#include <algorithm>
#include <cerrno>
#include <cinttypes>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "drivers/recording/natural_order.hpp"
#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

namespace fs = std::filesystem;

constexpr int kPngLevel = 3;  // recording at camera rate: half the time of level 6 for a few percent of size

// A name that stays inside the folder.
bool is_inner_path(std::string_view name) {
  const fs::path path{name};
  return !name.empty() && path.is_relative() && std::find(path.begin(), path.end(), fs::path("..")) == path.end();
}

std::optional<RecordedFrame> parse_row(std::string_view line) {
  const std::vector<std::string_view> fields = split_commas(line);
  if (fields.size() != 5 || !is_inner_path(fields[0])) return std::nullopt;
  const auto sequence = parse_number<std::uint64_t>(fields[1]);
  const auto time_ns = parse_number<std::int64_t>(fields[2]);
  const auto exposure_us = parse_number<std::uint32_t>(fields[3]);
  if (!sequence || !time_ns || !exposure_us) return std::nullopt;
  if (fields[4] != "0" && fields[4] != "1" && fields[4] != "2") return std::nullopt;
  return RecordedFrame{std::string(fields[0]), *sequence, *time_ns, *exposure_us, static_cast<StrobePhase>(fields[4][0] - '0')};
}

// The time of a frame so many after the first one, ns; none where it does not fit.
std::optional<std::int64_t> time_at(std::uint64_t frames, double rate_hz) {
  const double time_ns = std::round(static_cast<double>(frames) * 1e9 / rate_hz);
  if (time_ns > 9e18) return std::nullopt;
  return static_cast<std::int64_t>(time_ns);
}

bool is_rate(double rate_hz) { return rate_hz > 0 && std::isfinite(rate_hz); }

Problem too_slow(const std::string& where, double rate_hz) {
  return {Exit::kUsage, "the rate is too low", where, "times within 9e9 s", number_text(rate_hz) + " Hz", ""};
}

Outcome<void> read_listing(const fs::path& file, const RecordingTimes& times, Recording& recording) {
  const Outcome<std::string> text = read_text_file(file, "a listing: " + std::string(kFramesHeader), std::size_t{1} << 30);
  if (!text) return text.error();
  const std::vector<TextLine> lines = split_lines(*text);
  if (lines.size() == 1 && !lines[0].ended && kFramesHeader.starts_with(lines[0].text)) {
    recording.listed = recording.cut = true;
    return {};
  }
  if (lines.empty() || trimmed(lines[0].text) != kFramesHeader)
    return Problem{Exit::kInput,
                   "has another header",
                   file.string() + ":1",
                   std::string(kFramesHeader),
                   lines.empty() ? "an empty file" : "'" + std::string(lines[0].text.substr(0, 80)) + "'",
                   "write that header, or delete the file and give a rate"};
  std::uint64_t first_sequence = 0;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const TextLine& line = lines[i];
    if (trimmed(line.text).empty()) continue;
    std::optional<RecordedFrame> frame = parse_row(line.text);
    const std::string where = file.string() + ":" + std::to_string(line.number);
    if (!frame) {
      if (!line.ended) {  // whole numbers and one digit at the end: no cut row reads as a whole one
        recording.cut = true;
        break;
      }
      return Problem{Exit::kInput,
                     "is not a frame",
                     where,
                     std::string(kFramesHeader) + "; file inside the folder, whole numbers, strobe 0, 1 (lit) or 2 (dark)",
                     "'" + std::string(line.text.substr(0, 120)) + "'",
                     ""};
    }
    if (!recording.frames.empty()) {
      const RecordedFrame& before = recording.frames.back();
      if (frame->sequence <= before.sequence)
        return Problem{Exit::kInput,
                       "'sequence' does not grow",
                       where,
                       "more than " + std::to_string(before.sequence),
                       std::to_string(frame->sequence),
                       ""};
      if (!times.from_sequence && frame->time_ns < before.time_ns)
        return Problem{Exit::kInput,
                       "'time_ns' falls: the clock was set back while this was recorded",
                       where,
                       "at least " + std::to_string(before.time_ns),
                       std::to_string(frame->time_ns),
                       "give the camera's frame rate, --rate HZ: times then follow from the sequence"};
    }
    if (times.from_sequence) {
      if (recording.frames.empty()) first_sequence = frame->sequence;
      const auto time_ns = time_at(frame->sequence - first_sequence, times.rate_hz);
      if (!time_ns) return too_slow(where, times.rate_hz);
      frame->time_ns = *time_ns;
    }
    recording.frames.push_back(*frame);
  }
  recording.listed = true;
  if (times.from_sequence)
    recording.notes.push_back("times follow from the sequence at " + number_text(times.rate_hz) +
                              " Hz: those in frames.csv are not used");
  return {};
}

Outcome<void> list_images(double rate_hz, Recording& recording) {
  const std::string where = recording.folder.string();
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(recording.folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    std::error_code ignored;
    if (is_image_name(name) && name != kReferenceName && !it->is_directory(ignored)) names.push_back(name);
  }
  if (error) return Problem{Exit::kInput, "cannot be listed", where, "a readable folder", error.message(), ""};
  if (names.empty())
    return Problem{Exit::kInput, "holds neither frames.csv nor images",  where, "a recording",
                   "",           "name the folder that holds the images"};
  if (!is_rate(rate_hz))
    return Problem{Exit::kUsage,
                   "has no frames.csv, so the frame rate must be given",
                   where,
                   "a rate in Hz above 0",
                   number_text(rate_hz),
                   "give the camera's frame rate"};
  if (std::string note = sort_naturally(names); !note.empty()) recording.notes.push_back(std::move(note));
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto time_ns = time_at(i, rate_hz);
    if (!time_ns) return too_slow(where, rate_hz);
    recording.frames.push_back({names[i], i, *time_ns, 0, StrobePhase::kUnstrobed});
  }
  return {};
}

}  // namespace

Outcome<Recording> read_recording(const fs::path& folder, const RecordingTimes& times) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    return Problem{Exit::kInput,
                   fs::exists(folder, error) ? "is not a folder" : "no such folder",
                   folder.string(),
                   "a folder with a recording",
                   "",
                   "check the path"};
  Recording recording;
  recording.folder = folder;
  const fs::path listing = folder / kFramesName;
  if (times.from_sequence && !is_rate(times.rate_hz))
    return Problem{Exit::kUsage, "the frame rate", folder.string(), "a rate in Hz above 0", number_text(times.rate_hz), ""};
  const Outcome<void> read =
      fs::exists(listing, error) ? read_listing(listing, times, recording) : list_images(times.rate_hz, recording);
  if (!read) return read.error();
  if (recording.frames.empty())
    return Problem{Exit::kInput, "lists no whole frame", listing.string(), "at least one row", "", ""};
  return recording;
}

Outcome<fs::path> make_recording_folder(const fs::path& folder, bool overwrite) {
  std::error_code error;
  const fs::path listing = folder / kFramesName;
  if (fs::exists(listing, error) && !overwrite)
    return Problem{Exit::kUsage,
                   "a recording is there already",
                   listing.string(),
                   "a new folder",
                   "",
                   "name another folder, or add --force to replace it"};
  fs::create_directories(folder, error);
  if (error) return Problem{Exit::kInput, "cannot be made", folder.string(), "a writable place", error.message(), ""};
  return listing;
}

Outcome<RecordingWriter> RecordingWriter::create(const fs::path& folder, ImageFormat format, bool overwrite) {
  const Outcome<fs::path> made = make_recording_folder(folder, overwrite);
  if (!made) return made.error();
  const fs::path& listing = *made;
  RecordingWriter writer;
  writer.folder_ = folder;
  writer.format_ = format;
  writer.listing_.reset(std::fopen(listing.c_str(), "wb"));
  if (!writer.listing_ || std::fprintf(writer.listing_.get(), "%s\n", kFramesHeader.data()) < 0 ||
      std::fflush(writer.listing_.get()) != 0)
    return Problem{Exit::kInput,         "cannot be written",
                   listing.string(),     "a writable folder with room",
                   std::strerror(errno), "check the folder, its permissions and the disk"};
  return writer;
}

Outcome<void> RecordingWriter::add(const GrayView& image, const RecordedFrame& frame) {
  char name[32];
  std::snprintf(name, sizeof name, "frame_%06d.%s", frames_, format_ == ImageFormat::kPng ? "png" : "pgm");
  if (Outcome<void> written = write_gray_image(folder_ / name, image, kPngLevel); !written) return written;
  if (std::fprintf(listing_.get(), "%s,%" PRIu64 ",%" PRId64 ",%" PRIu32 ",%d\n", name, frame.sequence, frame.time_ns,
                   frame.exposure_us, static_cast<int>(frame.strobe)) < 0 ||
      std::fflush(listing_.get()) != 0)
    return Problem{Exit::kInput,         "cannot be written",  (folder_ / kFramesName).string(),
                   "a folder with room", std::strerror(errno), "check the disk"};
  ++frames_;
  return {};
}

}  // namespace srd
