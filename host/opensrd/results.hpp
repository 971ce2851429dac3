// SPDX-License-Identifier: Apache-2.0
// Result files as OpenSRD names and orders them. Its guide and its code of 2016 start at the last frame; the release of
// 2017 goes forward. Records are chronological everywhere else.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "host/opensrd/settings.hpp"
#include "host/run/frame_record.hpp"

namespace srd::host::opensrd {

// Where everything goes. Paths in the settings keep their folders; absolute ones, and ones that climb out of the
// settings' folder, keep their last name only.
struct OutputPlan {
  std::filesystem::path coefficients;           // empty: a recording has none
  std::filesystem::path errors;                 // empty: not asked for
  std::filesystem::path centres;                // 2017 only; empty: not asked for
  std::vector<std::filesystem::path> poses;     // one a camera; empty: not asked for
  std::vector<std::filesystem::path> features;  // folder, one a camera; empty: not asked for
  std::filesystem::path series;                 // surface.csv, chronological
  std::filesystem::path summary;                // summary.txt
};

// with_poses, with_features: whether this run makes any. kUsage when two results would share a file.
[[nodiscard]] Outcome<OutputPlan> plan_outputs(const Settings& settings, const std::filesystem::path& out, bool with_poses,
                                               bool with_features);
// kUsage when a result is there already and force is false. Changes nothing.
[[nodiscard]] Outcome<void> check_free(const OutputPlan& plan, bool force);
// check_free, then makes the folders. With force, Frame_k.txt of an earlier run are removed, so that no two runs mix.
[[nodiscard]] Outcome<void> prepare_outputs(const OutputPlan& plan, bool force);

// "Frame_0.txt"
[[nodiscard]] std::string frame_file_name(std::size_t k);
// The Frame_k.txt of a folder by k; nothing when there is no such folder.
[[nodiscard]] std::vector<std::filesystem::path> numbered_frames(const std::filesystem::path& folder);
// Where a name of the settings goes below out.
[[nodiscard]] std::filesystem::path placed_below(const std::filesystem::path& out, const std::filesystem::path& given,
                                                 const std::filesystem::path& settings_folder);

// Which chronological frame stands at place k of the dialect's order (line k, Frame_k.txt).
[[nodiscard]] std::size_t frame_at(Dialect dialect, std::size_t k, std::size_t frames);

// "[a0,a1,..]", 5 decimals, a line a frame; "[nan,..]" where there is no surface.
[[nodiscard]] std::string coefficients_text(Dialect dialect, std::span<const FrameRecord> frames, int parameters);
// Mean error of each frame, a line a frame; "nan" where there is no surface.
[[nodiscard]] std::string errors_text(Dialect dialect, std::span<const FrameRecord> frames);
// "[X,Y]" (mm, 5 decimals) of where the region's middle meets the surface, a line a frame; "[nan,nan]" without one.
[[nodiscard]] std::string centres_text(Dialect dialect, std::span<const FrameRecord> frames);
// Frame_k.txt of one camera: id u v of its corners, undistorted pixels. ids: per point of the run, the line of the
// camera's own file of feature points.
[[nodiscard]] Outcome<void> write_feature_files(const std::filesystem::path& folder, Dialect dialect,
                                                std::span<const FrameRecord> frames, std::size_t camera,
                                                const dsp::CameraModel<double>& model, std::span<const int> ids);

}  // namespace srd::host::opensrd
