// SPDX-License-Identifier: Apache-2.0
// The board in each image of a calibration: its corners with their deviations, whole or in part.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/recording/image_file.hpp"
#include "host/bundle/camera_solve.hpp"

namespace srd::host {

struct BoardSearch {
  int radius = 5;            // px, 5 or 10
  int threshold = 0;         // least response; 0: what the image's own noise does not reach
  double min_distance = 15;  // px
};

struct SightedBoard {
  std::filesystem::path file;
  int width = 0, height = 0;           // of the image, px
  bundle::BoardView view;              // rows and columns counted from the grid's own first corner
  int rows = 0, columns = 0;           // of the grid; less than the board's where it is partly seen
  int threshold = 0;                   // that found it
  std::optional<bool> bright_first{};  // the square between more rows and more columns at the first cell; nothing: unclear
  std::size_t number = 0;              // among the images, in their order
  [[nodiscard]] bool whole_extent(const bundle::BoardShape& board) const {
    return rows == board.rows && columns == board.columns;
  }
};

// The board of this size among all grids of the image, also turned by a quarter. A part of it serves from 4 x 4 corners
// on. kInput: no such board; the message says what was found.
[[nodiscard]] Outcome<SightedBoard> sight_board(const GrayImage& image, const std::filesystem::path& file,
                                                const bundle::BoardShape& board, const BoardSearch& search);

}  // namespace srd::host
