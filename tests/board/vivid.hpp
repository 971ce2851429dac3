// SPDX-License-Identifier: Apache-2.0
// The kernel's virtual video device, from the test's side: where it is, its inputs, its controls by name.
#pragma once

#include <linux/videodev2.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera/v4l2/v4l2_offers.hpp"
#include "drivers/camera/v4l2/v4l2_port.hpp"

namespace srd::board {

// A device node of vivid, open beside the driver under test.
class Vivid {
 public:
  // The first capture node of vivid; none when its module is not loaded.
  [[nodiscard]] static std::optional<Vivid> find(std::uint32_t capability = V4L2_CAP_VIDEO_CAPTURE);

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] V4l2Port& port() { return *port_; }
  // False when there is no such control (or menu item).
  bool set(const std::string& control, std::int32_t value);
  bool choose(const std::string& control, const std::string& item);
  bool set_input(int index);
  // Of the inputs, the first whose name begins so; -1: none.
  [[nodiscard]] int input_named(const std::string& start);
  // Opened again: after a disconnect, when this is the last one that holds it open, vivid comes back.
  void close() { port_->close(); }
  [[nodiscard]] bool reopen() { return port_->open(path_.c_str()) == 0; }

 private:
  [[nodiscard]] std::optional<v4l2_queryctrl> control_named(const std::string& name);
  std::string path_;
  std::unique_ptr<V4l2Port> port_;
};

}  // namespace srd::board
