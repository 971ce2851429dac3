// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace srd::host {

// Inner corners of a board. Rows run along the image's v, columns along u. OpenSRD calls rows "Width" and columns "Height".
struct PatternSize {
  int rows = 0;
  int columns = 0;
  [[nodiscard]] int count() const { return rows * columns; }
};

}  // namespace srd::host
