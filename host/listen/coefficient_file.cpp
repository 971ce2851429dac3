// SPDX-License-Identifier: Apache-2.0
#include "host/listen/coefficient_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "drivers/support/csv_table.hpp"
#include "host/coefficients/columns.hpp"
#include "host/coefficients/row_writer.hpp"
#include "host/listen/frames_in_file.hpp"
#include "proto/plain_word.hpp"

namespace srd::host {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kWriteAt = 1 << 16;  // bytes pending

Problem failed(const fs::path& path, const char* action, int error) {
  return {.exit = Exit::kDevice, .what = std::string("cannot ") + action + ": " + std::strerror(error), .where = path.string()};
}

Problem exists_already(const fs::path& path) {
  return {.exit = Exit::kUsage,
          .what = "the file is there already",
          .where = path.string(),
          .advice = "another name, --append to go on with it, or --force to write it anew"};
}

// The number that was meant: 1.333, not the nearest float's 1.33299994.
double decimal(float value) {
  std::array<char, 32> text;
  const char* end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  double meant = 0;
  std::from_chars(text.data(), end, meant);
  return meant;
}

NodeModel model_of(const proto::BootId& from, const proto::CoefficientFrame& frame) {
  const dsp::SurfaceModel<float>& model = frame.model;
  NodeModel out{std::string(from.node.view()),
                {model.modes, decimal(model.lx), decimal(model.ly), decimal(model.x0), decimal(model.y0)},
                decimal(frame.refractive_index),
                std::nullopt};
  for (const dsp::Layer<float>& plate : frame.plates) out.plates.push_back({decimal(plate.thickness), decimal(plate.index)});
  if (frame.systematic.pose_day) out.systematic = ErrorSources{*frame.systematic.pose_day, frame.systematic.calibration_day};
  if (frame.pattern_x_mm > 0 && frame.pattern_y_mm > 0) {
    const double x = decimal(frame.centre_x_mm), y = decimal(frame.centre_y_mm);
    const double half_x = decimal(frame.pattern_x_mm) / 2, half_y = decimal(frame.pattern_y_mm) / 2;
    out.pattern = PatternExtent{x - half_x, x + half_x, y - half_y, y + half_y};
  }
  return out;
}

}  // namespace

Outcome<void> CoefficientFile::open_file(const fs::path& path, File& file) {
  const int flags = mode_ == OpenMode::kNew ? O_EXCL : mode_ == OpenMode::kReplace ? O_TRUNC : O_APPEND;
  std::error_code ignored;
  const bool is_new = !fs::exists(path, ignored);
  file.path = path;
  file.fd.reset(::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | flags, 0644));
  if (file.fd.valid()) {
    // The name must outlive a power cut as the rows do.
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    const UniqueFd entry(is_new ? ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1);
    if (entry.valid()) (void)::fsync(entry.get());
    return {};
  }
  const int error = errno;
  if (error == EEXIST) return exists_already(path);
  return failed(path, "write the file", error);
}

fs::path CoefficientFile::beside(const std::string& part) const {
  fs::path path = path_;
  path.replace_filename(path_.stem().string() + "." + part + path_.extension().string());
  return path;
}

Outcome<std::unique_ptr<CoefficientFile>> CoefficientFile::open(const fs::path& file, OpenMode mode) {
  std::unique_ptr<CoefficientFile> made(new CoefficientFile(file, mode));
  std::error_code ignored;
  if (mode == OpenMode::kAppend) {
    if (fs::exists(file, ignored))
      if (const auto done = made->take_over(file); !done) return done.error();
    for (const fs::path& further : made->further_files())
      if (const auto done = made->take_over(further); !done) return done.error();
  } else if (const auto further = made->further_files(); mode == OpenMode::kNew && !further.empty()) {
    return exists_already(further.front());
  }
  if (made->files_.empty())
    if (const auto done = made->open_file(file, made->files_[""]); !done) return done.error();
  return made;
}

// Files beside this one that a node with another list of modes would get: run.A00-B-C.csv.
std::vector<fs::path> CoefficientFile::further_files() const {
  std::vector<fs::path> found;
  std::error_code ignored;
  const fs::path folder = path_.has_parent_path() ? path_.parent_path() : fs::path(".");
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    const fs::path stem = entry.path().stem();  // run.A00-B-C
    if (entry.path().extension() != path_.extension() || stem.stem() != path_.stem()) continue;
    if (name == path_.filename()) continue;
    const auto present = read_frames_in_file(entry.path());
    if (present.ok() && present->modes && stem.extension() == "." + joined(*present->modes, "-"))
      found.push_back(path_.has_parent_path() ? folder / name : fs::path(name));
  }
  return found;
}

// Reads which frames a file has, cuts off a torn last line and opens it.
Outcome<void> CoefficientFile::take_over(const fs::path& path) {
  auto present = read_frames_in_file(path);
  if (!present) return present.error();
  File& file = files_[present->modes ? joined(*present->modes, "-") : ""];
  if (const auto done = open_file(path, file); !done) return done;
  if (::ftruncate(file.fd.get(), static_cast<off_t>(present->whole_bytes)) != 0)
    return failed(path, "cut off the torn last line", errno);
  if (std::error_code ignored; fs::exists(model_file_path(path), ignored)) {
    // One that cannot be read is written anew with the next boot's first row.
    if (auto models = read_model_file(model_file_path(path)); models.ok())
      file.models = std::move(*models);
    else
      notes_.push_back(models.error().text());
  }
  for (auto& [boot, frames] : present->frames)
    for (const proto::SequenceRange& range : frames.ranges()) in_file_[boot].add(range);
  return {};
}

Outcome<CoefficientFile::File*> CoefficientFile::file_for(const dsp::ModeList& modes) {
  const std::string names = joined(modes, "-");
  if (const auto found = files_.find(names); found != files_.end()) return &found->second;
  File* file = nullptr;
  if (const auto first = files_.find(""); first != files_.end()) {
    auto node = files_.extract(first);
    node.key() = names;
    file = &files_.insert(std::move(node)).position->second;
  } else {
    File opened;
    if (const auto done = open_file(beside(names), opened); !done) return done.error();
    file = &files_.emplace(names, std::move(opened)).first->second;
  }
  file->pending += coefficient_header(modes);
  return file;
}

// Before the boot's first row is safe, so that no row is without its model.
Outcome<void> CoefficientFile::describe_model(const proto::BootId& from, const proto::CoefficientFrame& frame, File& file) {
  if (!file.described.insert(from).second) return {};
  const NodeModel model = model_of(from, frame);
  ModelFile wanted = file.models;
  const auto known =
      std::find_if(wanted.nodes.begin(), wanted.nodes.end(), [&](const NodeModel& other) { return other.node == model.node; });
  if (known == wanted.nodes.end()) {
    wanted.nodes.push_back(model);
    if (proto::reads_as_value(model.node))
      notes_.push_back("node '" + model.node +
                       "': programs that read tables take this name for a number, a date, a truth value or "
                       "a missing one; it is recorded as it is. Better: another node.id in the node's configuration");
  } else {
    if (model_file_text({{*known}}) == model_file_text({{model}})) return {};
    notes_.push_back(model.node + " came back with another surface model: rows of " + file.path.string() + " before boot " +
                     boot_text(from.boot) + " do not belong to the model beside it");
    *known = model;
  }
  file.models = std::move(wanted);
  if (auto done = write_model_file(model_file_path(file.path), file.models); !done) {
    Problem problem = done.error();
    problem.exit = Exit::kDevice;
    return problem;
  }
  return {};
}

Outcome<void> CoefficientFile::write(const proto::BootId& from, std::uint64_t sequence, const proto::CoefficientFrame& frame) {
  const auto file = file_for(frame.model.modes);
  if (!file) return file.error();
  if (auto done = describe_model(from, frame, **file); !done) return done;
  append_row(row_content(from, sequence, frame), (*file)->pending);
  return (*file)->pending.size() < kWriteAt ? Outcome<void>() : write_out(**file);
}

Outcome<void> CoefficientFile::write_out(File& file) {
  std::size_t written = 0;
  while (written < file.pending.size()) {
    const ssize_t bytes = ::write(file.fd.get(), file.pending.data() + written, file.pending.size() - written);
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes < 0) return failed(file.path, "write", errno);
    written += static_cast<std::size_t>(bytes);
  }
  file.pending.clear();
  file.has_rows_to_sync = true;
  return {};
}

Outcome<void> CoefficientFile::flush() {
  const auto flush_one = [](File& file) -> Outcome<void> {
    if (!file.pending.empty())
      if (auto done = write_out(file); !done) return done;
    // Some places (a pipe, /dev/null) have nothing to sync.
    if (file.has_rows_to_sync && ::fdatasync(file.fd.get()) != 0 && errno != EINVAL && errno != EROFS)
      return failed(file.path, "flush", errno);
    file.has_rows_to_sync = false;
    return {};
  };
  for (auto& [names, file] : files_)
    if (auto done = flush_one(file); !done) return done;
  return {};
}

std::vector<fs::path> CoefficientFile::files() const {
  std::vector<fs::path> paths;
  for (const auto& [names, file] : files_) paths.push_back(file.path);
  return paths;
}

}  // namespace srd::host
