// SPDX-License-Identifier: Apache-2.0
#include "host/opensrd/results.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include "drivers/recording/natural_order.hpp"
#include "drivers/support/text_file.hpp"
#include "host/coefficients/model_file.hpp"
#include "host/run/features.hpp"

namespace srd::host::opensrd {

namespace {

namespace fs = std::filesystem;

std::string formatted(const char* format, double value) {
  if (!std::isfinite(value)) return "nan";
  std::array<char, 400> buffer;  // %.5f of the largest double is 315 characters
  const int length = std::snprintf(buffer.data(), buffer.size(), format, value);
  return {buffer.data(), static_cast<std::size_t>(length)};
}

bool is_frame_file(const fs::path& file) {
  const std::string name = file.filename().string();
  return name.starts_with("Frame_") && name.ends_with(".txt") && name.find_first_not_of("0123456789", 6) == name.size() - 4 &&
         name.size() > 10;
}

std::vector<fs::path> single_files(const OutputPlan& plan) {
  std::vector<fs::path> files = {plan.series, model_file_path(plan.series), plan.summary};
  for (const fs::path& file : {plan.coefficients, plan.errors, plan.centres})
    if (!file.empty()) files.push_back(file);
  files.insert(files.end(), plan.poses.begin(), plan.poses.end());
  return files;
}

}  // namespace

fs::path placed_below(const fs::path& out, const fs::path& given, const fs::path& settings_folder) {
  fs::path relative = given.lexically_normal();
  if (relative.is_absolute()) relative = relative.lexically_relative(fs::absolute(settings_folder).lexically_normal());
  if (relative.empty() || *relative.begin() == "..") relative = given.lexically_normal();
  if (!relative.has_filename()) relative = relative.parent_path();
  if (relative.is_absolute() || *relative.begin() == "..") relative = relative.filename();
  return out / relative;
}

std::string frame_file_name(std::size_t k) { return "Frame_" + std::to_string(k) + ".txt"; }

std::vector<fs::path> numbered_frames(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (is_frame_file(entry.path())) names.push_back(entry.path().filename().string());
  (void)sort_naturally(names);  // Frame_<digits>.txt can be read in one way only
  std::vector<fs::path> files;
  for (const std::string& name : names) files.push_back(folder / name);
  return files;
}

Outcome<OutputPlan> plan_outputs(const Settings& settings, const fs::path& out, bool with_poses, bool with_features) {
  const fs::path base = settings.file.parent_path();
  std::map<fs::path, std::string> owners;
  Problem shared;
  const auto place = [&](const fs::path& given, const std::string& what) {
    const fs::path path = placed_below(out, given, base);
    const auto [owner, is_new] = owners.emplace(path, what);
    if (!is_new && shared.what.empty())
      shared = {Exit::kUsage,
                "two results would share a file",
                settings.file.string(),
                "a name for each result",
                path.string() + " for " + owner->second + " and " + what,
                "change one of the names"};
    return path;
  };
  OutputPlan plan;
  plan.coefficients = place(settings.coefficients_output, "the coefficients");
  if (settings.save_errors) plan.errors = place(settings.errors_output, "the errors");
  if (!settings.patch.centres_output.empty()) plan.centres = place(settings.patch.centres_output, "the centres");
  for (std::size_t i = 0; i < settings.cameras.size(); ++i) {
    const std::string camera = "camera " + std::to_string(i + 1);
    if (with_poses && settings.save_pose) plan.poses.push_back(place(settings.cameras[i].pose_output, "the pose of " + camera));
    if (with_features && settings.save_features)
      plan.features.push_back(place(settings.cameras[i].features_output, "the features of " + camera));
  }
  plan.series = place("surface.csv", "the chronological series");
  plan.summary = place("summary.txt", "the summary");
  if (!shared.what.empty()) return shared;
  return plan;
}

Outcome<void> check_free(const OutputPlan& plan, bool force) {
  if (force) return {};
  const std::string advice = "give another --out, or --force to replace the results";
  std::error_code error;
  for (const fs::path& file : single_files(plan))
    if (fs::exists(file, error))
      return Problem{Exit::kUsage, "is there already", file.string(), "an --out folder without results", "", advice};
  for (const fs::path& folder : plan.features)
    if (const auto old = numbered_frames(folder); !old.empty())
      return Problem{Exit::kUsage,
                     "holds feature files already",
                     folder.string(),
                     "an --out folder without results",
                     old.front().filename().string(),
                     advice};
  return {};
}

Outcome<void> prepare_outputs(const OutputPlan& plan, bool force) {
  if (auto free = check_free(plan, force); !free) return free.error();
  std::vector<fs::path> folders = plan.features;
  for (const fs::path& file : single_files(plan)) folders.push_back(file.parent_path());
  std::error_code error;
  for (const fs::path& folder : folders) {
    fs::create_directories(folder, error);
    if (error)
      return Problem{Exit::kUsage,    "cannot be made",    folder.string(), "a folder that can be written",
                     error.message(), "give another --out"};
  }
  for (const fs::path& folder : plan.features)
    for (const fs::path& old : numbered_frames(folder)) fs::remove(old, error);
  return {};
}

std::size_t frame_at(Dialect dialect, std::size_t k, std::size_t frames) {
  return dialect == Dialect::k2017 ? k : frames - 1 - k;
}

std::string coefficients_text(Dialect dialect, std::span<const FrameRecord> frames, int parameters) {
  std::string text;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const FrameRecord& frame = frames[frame_at(dialect, k, frames.size())];
    for (int j = 0; j < parameters; ++j)
      text += (j == 0 ? "[" : ",") + formatted("%.5f", frame.has_surface() ? frame.estimate.coefficients[j] : std::nan(""));
    text += "]\n";
  }
  return text;
}

std::string errors_text(Dialect dialect, std::span<const FrameRecord> frames) {
  std::string text;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const FrameRecord& frame = frames[frame_at(dialect, k, frames.size())];
    text += formatted("%.6g", frame.has_surface() ? frame.estimate.mean_error : std::nan("")) + "\n";
  }
  return text;
}

std::string centres_text(Dialect dialect, std::span<const FrameRecord> frames) {
  std::string text;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const FrameRecord& frame = frames[frame_at(dialect, k, frames.size())];
    const bool known = frame.has_surface() && frame.centre;
    text += "[" + formatted("%.5f", known ? frame.centre->x() : std::nan("")) + "," +
            formatted("%.5f", known ? frame.centre->y() : std::nan("")) + "]\n";
  }
  return text;
}

Outcome<void> write_feature_files(const fs::path& folder, Dialect dialect, std::span<const FrameRecord> frames,
                                  std::size_t camera, const dsp::CameraModel<double>& model, std::span<const int> ids) {
  for (std::size_t k = 0; k < frames.size(); ++k) {
    std::vector<Feature> features;
    for (const auto& corner : frames[frame_at(dialect, k, frames.size())].corners[camera])
      features.push_back({ids[static_cast<std::size_t>(corner.point)], model.fx() * corner.normalised.x() + model.cx(),
                          model.fy() * corner.normalised.y() + model.cy()});
    std::sort(features.begin(), features.end(), [](const Feature& a, const Feature& b) { return a.id < b.id; });
    if (auto written = write_features(folder / frame_file_name(k), features); !written) return written.error();
  }
  return {};
}

}  // namespace srd::host::opensrd
