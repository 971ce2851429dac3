// SPDX-License-Identifier: Apache-2.0
// Exit codes of srd-node and srd. Ended by a signal: 128 + its number.
#pragma once

namespace srd {

enum class Exit : int {
  kDone = 0,
  kUsage = 2,    // the command line or the configuration is wrong
  kInput = 3,    // a file or what the camera shows cannot be used
  kDevice = 4,   // a device or the disk does not work
  kNetwork = 5,  // no connection, or not every frame reached the host
};

}  // namespace srd
