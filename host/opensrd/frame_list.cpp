// SPDX-License-Identifier: Apache-2.0
#include "host/opensrd/frame_list.hpp"

#include <algorithm>

#include "drivers/recording/image_file.hpp"
#include "drivers/recording/natural_order.hpp"
#include "host/opensrd/results.hpp"

namespace srd::host::opensrd {

namespace {

namespace fs = std::filesystem;

template <class Wanted>
Outcome<std::vector<fs::path>> files_in(const fs::path& folder, const std::string& expected, Wanted wanted,
                                        std::vector<std::string>& warnings) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    return Problem{Exit::kInput,
                   "no such folder",
                   folder.string(),
                   expected,
                   fs::exists(folder, error) ? "a file" : "",
                   "check the path in the settings"};
  std::vector<std::string> names;
  int others = 0;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (!entry.is_regular_file(error)) continue;
    const std::string name = entry.path().filename().string();
    if (name.starts_with('.')) continue;  // what a system keeps beside files
    if (wanted(entry.path()))
      names.push_back(name);
    else
      ++others;
  }
  if (names.empty())
    return Problem{Exit::kInput, "holds no frames", folder.string(), expected, std::to_string(others) + " other files", ""};
  if (const std::string note = sort_naturally(names); !note.empty()) warnings.push_back(folder.string() + ": " + note);
  std::vector<fs::path> files;
  for (const std::string& name : names) files.push_back(folder / name);
  return files;
}

}  // namespace

Outcome<std::vector<fs::path>> image_files(const fs::path& folder, std::vector<std::string>& warnings) {
  return files_in(
      folder, "images (.png .pgm .bmp .tif .jpg), their names in chronological order",
      [](const fs::path& file) { return is_image_name(file); }, warnings);
}

Outcome<std::vector<fs::path>> feature_files(const fs::path& folder, std::vector<std::string>& warnings) {
  return files_in(
      folder, "feature files (.txt: id u v a line), their names in chronological order",
      [](const fs::path& file) { return file.extension() == ".txt"; }, warnings);
}

Outcome<std::vector<fs::path>> saved_features(const fs::path& out, const CameraSettings& camera, std::size_t camera_index,
                                              const Settings& settings) {
  std::error_code error;
  std::vector<fs::path> folders;
  if (!camera.features_output.empty()) {
    folders.push_back(placed_below(out, camera.features_output, settings.file.parent_path()));
    folders.push_back(out / camera.features_output.filename());
  }
  folders.push_back(out / ("CAM" + std::to_string(camera_index + 1)));
  if (settings.cameras.size() == 1) folders.push_back(out);
  const auto is_there = [&](const fs::path& folder) { return !numbered_frames(folder).empty(); };
  const auto at = std::find_if(folders.begin(), folders.end(), is_there);
  if (at == folders.end()) {
    std::string places;
    for (const fs::path& folder : folders) places += (places.empty() ? "" : ", ") + folder.string();
    return Problem{Exit::kInput,
                   "no saved features of camera " + std::to_string(camera_index + 1),
                   out.string(),
                   "Frame_0.txt, Frame_1.txt, .. in one of " + places,
                   fs::is_directory(out, error) ? "none" : "no such folder",
                   "give the --out folder of the earlier run"};
  }
  const std::vector<fs::path> numbered = numbered_frames(*at);
  for (std::size_t k = 0; k < numbered.size(); ++k)
    if (numbered[k].filename() != frame_file_name(k))
      return Problem{Exit::kInput, "a frame is missing", at->string(), frame_file_name(k), numbered[k].filename().string(), ""};
  std::vector<fs::path> chronological(numbered.size());
  for (std::size_t k = 0; k < numbered.size(); ++k) chronological[frame_at(settings.dialect, k, numbered.size())] = numbered[k];
  return chronological;
}

}  // namespace srd::host::opensrd
