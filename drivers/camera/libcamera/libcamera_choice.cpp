// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/libcamera/libcamera_choice.hpp"

#include <algorithm>

namespace srd {

namespace {

using Formats = std::vector<libcamera::PixelFormat>;
using libcamera::StreamRole;

bool offered(const Formats& formats, const LibcameraFormat& wanted) {
  return std::find(formats.begin(), formats.end(), wanted.format) != formats.end();
}

bool is_monochrome(const LibcameraFormat& format) {
  return format.format == libcamera::formats::R8 || format.layout == GrayLayout::kLittleEndian;
}

}  // namespace

std::vector<StreamTry> streams_to_try(const Formats& raw, const Formats& processed) {
  std::vector<StreamTry> tries;
  for (const LibcameraFormat& format : kLibcameraFormats)
    if (is_monochrome(format) && offered(raw, format)) tries.push_back({StreamRole::Raw, format});
  for (const LibcameraFormat& format : kLibcameraFormats)
    if (offered(processed, format)) tries.push_back({StreamRole::Viewfinder, format});
  for (const LibcameraFormat& format : kLibcameraFormats)
    if (!is_monochrome(format) && offered(raw, format)) tries.push_back({StreamRole::Raw, format});
  return tries;
}

std::string why_not_raw(const Formats& raw, const StreamTry& taken) {
  if (taken.role == StreamRole::Raw || is_monochrome(taken.format)) return {};
  std::string mosaics, packed;
  for (const libcamera::PixelFormat& format : raw) {
    const std::string name = format.toString();
    const auto add = [&](std::string& names) { names += (names.empty() ? "" : ", ") + name; };
    if (std::any_of(kLibcameraFormats.begin(), kLibcameraFormats.end(),
                    [&](const LibcameraFormat& known) { return known.format == format; })) {
      if (name.starts_with("R") && !name.starts_with("RGB"))
        return "grey comes from the image processor, as " + taken.format.format.toString() + ": the raw stream (" + name +
               ") has not this size; calibrated in a size of it, the camera is read raw";
      continue;
    }
    if (name.starts_with("S") || name.starts_with("BAYER"))
      add(mosaics);
    else if (name.starts_with("R") || name.starts_with("MONO"))
      add(packed);
  }
  const std::string from = "grey comes from the image processor, as " + taken.format.format.toString() + ": ";
  if (!packed.empty()) return from + "the raw stream is packed (" + packed + "), which is not read";
  if (!mosaics.empty()) return from + "the raw stream is a colour sensor's mosaic (" + mosaics + ")";
  return {};
}

}  // namespace srd
