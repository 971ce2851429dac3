// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/v4l2/v4l2_list.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <vector>

#include "drivers/camera/v4l2/v4l2_offers.hpp"
#include "drivers/camera/v4l2/v4l2_plan.hpp"
#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

std::vector<int> node_numbers() {
  std::vector<int> numbers;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("video")) continue;
    if (const auto number = parse_number<int>(std::string_view(name).substr(5))) numbers.push_back(*number);
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

// The size that the device is set to, for formats whose sizes it does not list.
std::string current_size(V4l2Port& port, std::uint32_t type) {
  v4l2_format format;
  std::memset(&format, 0, sizeof format);
  format.type = type;
  if (port.control(VIDIOC_G_FMT, &format) != 0) return {};
  const bool planes = type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
  return std::to_string(planes ? format.fmt.pix_mp.width : format.fmt.pix.width) + "x" +
         std::to_string(planes ? format.fmt.pix_mp.height : format.fmt.pix.height) + " (as it is set)";
}

}  // namespace

std::string list_v4l2_cameras() {
  const std::unique_ptr<V4l2Port> port = system_v4l2_port();
  std::string text;
  for (const int number : node_numbers()) {
    const std::string path = "/dev/video" + std::to_string(number);
    if (const int error = port->open(path.c_str()); error != 0) {
      text += "  v4l2:" + path + "  cannot be opened: " + problem_of({V4l2Step::kOpen, error}, path).what + "\n";
      continue;
    }
    V4l2Identity identity;
    if (identify(*port, identity) != 0 || !identity.captures()) continue;
    const std::uint32_t type = identity.multi_planar() ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
    text += "  v4l2:" + path + "  " + identity.card + ", driver " + identity.driver + ", " + identity.bus +
            (identity.streams() ? "" : ", cannot stream into buffers") + "\n" +
            offers_text(offers_of(*port, type), "    ", current_size(*port, type)) + "\n";
  }
  return "V4L2 capture devices:\n" + (text.empty() ? "  none\n" : text);
}

}  // namespace srd
