// SPDX-License-Identifier: Apache-2.0
// The V4L2 capture devices of this machine, for a person.
#pragma once

#include <string>

namespace srd {

// Every /dev/videoN that captures: path, card, driver, bus, then its formats, sizes and rates, a line a format. Says
// which devices cannot be opened, and why. Ends with a line end.
[[nodiscard]] std::string list_v4l2_cameras();

}  // namespace srd
