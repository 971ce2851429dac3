// SPDX-License-Identifier: Apache-2.0
// A folder of stills: still_001.png, still_002.png, .. . A file of that name is whole at any moment, and none is ever replaced.
#pragma once

#include <filesystem>
#include <string>

#include "drivers/support/problem.hpp"
#include "dsp/core/image_view.hpp"

namespace srd::firmware {

class StillFolder {
 public:
  // Makes the folder where there is none; numbers go on behind those of its stills. kInput when it cannot be had.
  [[nodiscard]] static Outcome<StillFolder> open(const std::filesystem::path& folder);

  // Written under a hidden name, brought to the disk, then renamed. The file's name; kInput, and nothing of the image is left,
  // when the disk does not take it.
  [[nodiscard]] Outcome<std::string> add(const GrayView& image);
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
  unsigned last_ = 0;
};

}  // namespace srd::firmware
