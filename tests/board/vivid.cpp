// SPDX-License-Identifier: Apache-2.0
#include "tests/board/vivid.hpp"

#include <cstring>

namespace srd::board {

std::optional<Vivid> Vivid::find(std::uint32_t capability) {
  for (int i = 0; i < 64; ++i) {
    Vivid vivid;
    vivid.path_ = "/dev/video" + std::to_string(i);
    vivid.port_ = system_v4l2_port();
    V4l2Identity identity;
    if (vivid.port_->open(vivid.path_.c_str()) == 0 && identify(*vivid.port_, identity) == 0 && identity.driver == "vivid" &&
        (identity.capabilities & capability) != 0)
      return vivid;
  }
  return std::nullopt;
}

std::optional<v4l2_queryctrl> Vivid::control_named(const std::string& name) {
  v4l2_queryctrl control;
  std::memset(&control, 0, sizeof control);
  control.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (port_->control(VIDIOC_QUERYCTRL, &control) == 0) {
    if (name == reinterpret_cast<const char*>(control.name)) return control;
    control.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return std::nullopt;
}

bool Vivid::set(const std::string& name, std::int32_t value) {
  const auto control = control_named(name);
  if (!control) return false;
  v4l2_control set{control->id, value};
  return port_->control(VIDIOC_S_CTRL, &set) == 0;
}

bool Vivid::choose(const std::string& name, const std::string& item) {
  const auto control = control_named(name);
  if (!control) return false;
  for (std::int32_t i = control->minimum; i <= control->maximum; ++i) {
    v4l2_querymenu menu;
    std::memset(&menu, 0, sizeof menu);
    menu.id = control->id;
    menu.index = static_cast<std::uint32_t>(i);
    if (port_->control(VIDIOC_QUERYMENU, &menu) == 0 && item == reinterpret_cast<const char*>(menu.name)) return set(name, i);
  }
  return false;
}

bool Vivid::set_input(int index) { return port_->control(VIDIOC_S_INPUT, &index) == 0; }

int Vivid::input_named(const std::string& start) {
  v4l2_input input;
  for (std::uint32_t i = 0;; ++i) {
    std::memset(&input, 0, sizeof input);
    input.index = i;
    if (port_->control(VIDIOC_ENUMINPUT, &input) != 0) return -1;
    if (std::string(reinterpret_cast<const char*>(input.name)).starts_with(start)) return static_cast<int>(i);
  }
}

}  // namespace srd::board
