// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/v4l2/v4l2_format.hpp"

namespace srd {

const V4l2PixelFormat* v4l2_format_of(std::uint32_t code) {
  for (const V4l2PixelFormat& format : kV4l2Formats)
    if (format.code == code) return &format;
  return nullptr;
}

std::string v4l2_format_names() {
  std::string names = "auto";
  std::string_view last;
  for (const V4l2PixelFormat& format : kV4l2Formats) {
    if (format.name != last) names += ", " + std::string(format.name);
    last = format.name;
  }
  return names;
}

bool is_v4l2_format_name(std::string_view name) {
  if (name == "auto") return true;
  for (const V4l2PixelFormat& format : kV4l2Formats)
    if (format.name == name) return true;
  return false;
}

std::string fourcc_text(std::uint32_t code) {
  std::string text;
  for (int i = 0; i < 4; ++i) {
    const char c = static_cast<char>((code >> (8 * i)) & 0x7f);
    const bool known = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == ' ';
    text += known ? c : '.';
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

}  // namespace srd
