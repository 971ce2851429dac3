// SPDX-License-Identifier: Apache-2.0
#include "host/run/pattern_mask.hpp"

namespace srd::host {

std::vector<std::uint8_t> pattern_mask(const GrayView& image, const Region& region, int dark_below, int bright_above) {
  const int width = region.u1 - region.u0, height = region.v1 - region.v0;
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 1);
  std::vector<int> open;
  const auto visit = [&](int u, int v) {
    if (u < 0 || v < 0 || u >= width || v >= height) return;
    const int level = image.row(region.v0 + v)[region.u0 + u], at = v * width + u;
    if (level < dark_below || level > bright_above || mask[static_cast<std::size_t>(at)] == 0) return;
    mask[static_cast<std::size_t>(at)] = 0;
    open.push_back(at);
  };
  for (int u = 0; u < width; ++u)
    for (const int v : {0, height - 1}) visit(u, v);
  for (int v = 0; v < height; ++v)
    for (const int u : {0, width - 1}) visit(u, v);
  while (!open.empty()) {
    const int u = open.back() % width, v = open.back() / width;
    open.pop_back();
    visit(u - 1, v);
    visit(u + 1, v);
    visit(u, v - 1);
    visit(u, v + 1);
  }
  return mask;
}

}  // namespace srd::host
