// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera/v4l2/v4l2_offers.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "drivers/camera/v4l2/v4l2_format.hpp"
#include "drivers/support/text_file.hpp"

namespace srd {

namespace {

// A driver that never says EINVAL must not hang the start.
constexpr std::uint32_t kMaxFormats = 64, kMaxSizes = 64, kMaxRates = 32;
constexpr std::size_t kShownSizes = 8;

double hz_of(const v4l2_fract& interval) {
  return interval.numerator == 0 ? 0 : static_cast<double>(interval.denominator) / interval.numerator;
}

template <std::size_t kLength>
std::string text_of(const std::uint8_t (&field)[kLength]) {
  const char* characters = reinterpret_cast<const char*>(field);
  return std::string(characters, strnlen(characters, kLength));
}

std::string hz_text(double hz) { return number_text(std::round(hz * 1000) / 1000); }

std::vector<V4l2Size> sizes_of(V4l2Port& port, std::uint32_t code) {
  std::vector<V4l2Size> sizes;
  for (std::uint32_t i = 0; i < kMaxSizes; ++i) {
    v4l2_frmsizeenum found;
    std::memset(&found, 0, sizeof found);
    found.index = i;
    found.pixel_format = code;
    if (port.control(VIDIOC_ENUM_FRAMESIZES, &found) != 0) break;
    V4l2Size size;
    if (found.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      size.width = size.least_width = static_cast<int>(found.discrete.width);
      size.height = size.least_height = static_cast<int>(found.discrete.height);
    } else {
      const v4l2_frmsize_stepwise& all = found.stepwise;
      size = {static_cast<int>(all.max_width),
              static_cast<int>(all.max_height),
              static_cast<int>(all.min_width),
              static_cast<int>(all.min_height),
              static_cast<int>(all.step_width),
              static_cast<int>(all.step_height),
              {}};
    }
    size.rates = rates_of(port, code, size.width, size.height);
    sizes.push_back(std::move(size));
    if (found.type != V4L2_FRMSIZE_TYPE_DISCRETE) break;
  }
  return sizes;
}

std::string pixels_text(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

// Of the grey image that is made of it.
std::string size_text(const V4l2Size& size, int reduction) {
  std::string text;
  if (size.step_width != 0 && (size.least_width != size.width || size.least_height != size.height))
    text = pixels_text(size.least_width / reduction, size.least_height / reduction) + " to ";
  text += pixels_text(size.width / reduction, size.height / reduction);
  const std::string rates = rates_text(size.rates);
  return rates.empty() ? text : text + " (" + rates + ")";
}

}  // namespace

bool V4l2Identity::captures() const { return (capabilities & (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE)) != 0; }
bool V4l2Identity::multi_planar() const { return captures() && (capabilities & V4L2_CAP_VIDEO_CAPTURE) == 0; }
bool V4l2Identity::streams() const { return (capabilities & V4L2_CAP_STREAMING) != 0; }

std::string V4l2Identity::kind() const {
  if (captures()) return streams() ? "a video capture device" : "a capture device that cannot stream into buffers";
  if ((capabilities & (V4L2_CAP_VIDEO_M2M | V4L2_CAP_VIDEO_M2M_MPLANE)) != 0) return "a video converter (memory to memory)";
  if ((capabilities & (V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_VIDEO_OUTPUT_MPLANE)) != 0) return "a video output";
  if ((capabilities & (V4L2_CAP_META_CAPTURE | V4L2_CAP_META_OUTPUT)) != 0) return "a metadata node of a camera";
  if ((capabilities & (V4L2_CAP_VBI_CAPTURE | V4L2_CAP_VBI_OUTPUT)) != 0) return "a teletext (VBI) device";
  if ((capabilities & (V4L2_CAP_RADIO | V4L2_CAP_SDR_CAPTURE)) != 0) return "a radio";
  return "a video device that captures nothing";
}

int identify(V4l2Port& port, V4l2Identity& identity) {
  v4l2_capability found;
  std::memset(&found, 0, sizeof found);
  if (const int error = port.control(VIDIOC_QUERYCAP, &found); error != 0) return error;
  identity.card = text_of(found.card);
  identity.driver = text_of(found.driver);
  identity.bus = text_of(found.bus_info);
  identity.capabilities = (found.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? found.device_caps : found.capabilities;
  return 0;
}

V4l2Rates rates_of(V4l2Port& port, std::uint32_t code, int width, int height) {
  V4l2Rates rates;
  for (std::uint32_t i = 0; i < kMaxRates; ++i) {
    v4l2_frmivalenum found;
    std::memset(&found, 0, sizeof found);
    found.index = i;
    found.pixel_format = code;
    found.width = static_cast<std::uint32_t>(width);
    found.height = static_cast<std::uint32_t>(height);
    if (port.control(VIDIOC_ENUM_FRAMEINTERVALS, &found) != 0) break;
    if (found.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      rates.hz.push_back(hz_of(found.discrete));
    } else {  // the longest interval is the lowest rate
      rates.hz = {hz_of(found.stepwise.max), hz_of(found.stepwise.min)};
      rates.range = true;
      break;
    }
  }
  std::sort(rates.hz.begin(), rates.hz.end());
  return rates;
}

std::vector<V4l2Offer> offers_of(V4l2Port& port, std::uint32_t buffer_type) {
  std::vector<V4l2Offer> offers;
  for (std::uint32_t i = 0; i < kMaxFormats; ++i) {
    v4l2_fmtdesc found;
    std::memset(&found, 0, sizeof found);
    found.index = i;
    found.type = buffer_type;
    if (port.control(VIDIOC_ENUM_FMT, &found) != 0) break;
    V4l2Offer offer;
    offer.code = found.pixelformat;
    offer.description = text_of(found.description);
    offer.compressed = (found.flags & V4L2_FMT_FLAG_COMPRESSED) != 0;
    if (v4l2_format_of(offer.code) != nullptr) offer.sizes = sizes_of(port, offer.code);
    offers.push_back(std::move(offer));
  }
  return offers;
}

std::string rates_text(const V4l2Rates& rates) {
  if (rates.hz.empty()) return {};
  if (rates.range) return hz_text(rates.hz.front()) + " to " + hz_text(rates.hz.back()) + " Hz";
  std::string text;
  for (const double hz : rates.hz) text += (text.empty() ? "" : ", ") + hz_text(hz);
  return text + " Hz";
}

std::string offers_text(const std::vector<V4l2Offer>& offers, const std::string& margin, const std::string& fallback) {
  std::string text, others;
  for (const V4l2Offer& offer : offers) {
    const V4l2PixelFormat* format = v4l2_format_of(offer.code);
    if (format == nullptr) {
      others += (others.empty() ? "" : ", ") + fourcc_text(offer.code);
      continue;
    }
    std::string line = std::string(format->name) + (format->reduction() > 1 ? " (colour, halved)" : "");
    for (std::size_t i = 0; i < offer.sizes.size() && i < kShownSizes; ++i)
      line += (i == 0 ? " " : ", ") + size_text(offer.sizes[i], format->reduction());
    if (offer.sizes.size() > kShownSizes) line += ", " + std::to_string(offer.sizes.size() - kShownSizes) + " more";
    if (offer.sizes.empty() && !fallback.empty()) line += " " + fallback;
    text += (text.empty() ? "" : "\n") + margin + line;
  }
  if (!others.empty()) text += (text.empty() ? "" : "\n") + margin + "not usable: " + others;
  return text.empty() ? margin + "nothing" : text;
}

}  // namespace srd
