// SPDX-License-Identifier: Apache-2.0
// Which of a libcamera camera's streams grey comes from.
//
// A monochrome sensor's raw stream is the light itself; its processed streams have gone through the board's image processor,
// which may sharpen and remove noise, so raw goes first. A colour sensor's raw stream is a mosaic: no pixel has its neighbour's
// colour, and its green ones alone are a grid turned by 45 degrees, or half the resolution. There the Y of the processed stream
// is taken, with sharpening and noise reduction off (libcamera_image.hpp).
#pragma once

#include <string>
#include <vector>

#include <libcamera/pixel_format.h>
#include <libcamera/stream.h>

#include "drivers/camera/libcamera/libcamera_formats.hpp"

namespace srd {

struct StreamTry {
  libcamera::StreamRole role;
  LibcameraFormat format;
};

// raw, processed: what the camera offers for StreamRole::Raw and ::Viewfinder. In the order in which they are to be tried: raw
// streams of monochrome sensors, processed ones, others that come by the raw role (some pipelines ignore roles).
[[nodiscard]] std::vector<StreamTry> streams_to_try(const std::vector<libcamera::PixelFormat>& raw,
                                                    const std::vector<libcamera::PixelFormat>& processed);

// For a person, where taken is not a raw stream of a monochrome sensor: why none is. Empty: nothing to say.
[[nodiscard]] std::string why_not_raw(const std::vector<libcamera::PixelFormat>& raw, const StreamTry& taken);

}  // namespace srd
