// SPDX-License-Identifier: Apache-2.0
// Which point of the pattern each corner of a reference image is: from the camera's position (guide, appendix A), from a
// corner that somebody points at, or from what makes the pattern unlike itself when turned.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/pose/reference.hpp"

namespace srd::host {

enum class OriginSquare : std::uint8_t { kDark, kBright, kUnknown };

struct OrderKnowledge {
  int position = 0;                               // 1 to 4; 0: not known
  std::optional<dsp::Vec2<double>> first_corner;  // about where the first point of the list is seen, px
  // The square between (0, 0) and (1, 1) squares of the world, as in every pattern of the optics page.
  OriginSquare origin = OriginSquare::kDark;
};

struct BoardOrder {
  std::vector<int> points;  // of each corner: its place in the list
  std::string how;          // "camera position 2", "a mark in the first square", ..
};

// points: row by row, board.rows of board.columns. kInput: the board looks alike in two orders and nothing tells which, a
// first corner that is near none or two of the board's outer corners, or an order that contradicts the squares' colours.
[[nodiscard]] Outcome<BoardOrder> order_of(const ReferenceView& view, std::span<const dsp::Vec3<double>> points,
                                           PatternSize board, const OrderKnowledge& known, const std::string& where);

}  // namespace srd::host
