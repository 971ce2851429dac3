// SPDX-License-Identifier: Apache-2.0
#include "host/fusion/fusion_file.hpp"

#include <cmath>

#include "drivers/support/modes_key.hpp"
#include "drivers/support/toml_reader.hpp"

namespace srd::host {
namespace {

const NumberRange kPlace{-1e6, 1e6, "mm"};
const NumberRange kLength{0.001, 1e6, "mm"};

void read_surface(TomlTable surface, FusionOptions& options) {
  if (!surface.has("modes") && !surface.has("parameters"))
    surface.missing("modes", "the common surface's modes, or parameters");
  const auto modes = read_modes(surface);
  const auto lx = surface.number("lx_mm", kLength), ly = surface.number("ly_mm", kLength);
  if (!surface.has("lx_mm")) surface.missing("lx_mm", "the length scale of the modes, mm");
  if (!surface.has("ly_mm")) surface.missing("ly_mm", "the length scale of the modes, mm");
  const double x0 = surface.number("x0_mm", kPlace).value_or(0), y0 = surface.number("y0_mm", kPlace).value_or(0);
  if (modes && lx && ly) options.model = dsp::SurfaceModel<double>{*modes, *lx, *ly, x0, y0};
}

void read_board(TomlTable& board, FusionOptions& options) {
  const auto node = board.text("node");
  if (!node) {
    if (!board.has("node")) board.missing("node", "the id of a node");
    return;
  }
  if (!proto::NodeId::make(*node)) {
    board.complain("node", "the id of a node: 1 to 31 letters, digits, '-', '_', '.'", "\"" + *node + "\"");
    return;
  }
  BoardInFusion place;
  place.placement.x_mm = board.number("x_mm", kPlace).value_or(0);
  place.placement.y_mm = board.number("y_mm", kPlace).value_or(0);
  place.placement.z_mm = board.number("z_mm", {-1e4, 1e4, "mm"}).value_or(0);
  place.placement.turn_rad = board.number("turn_deg", {-360, 360, "degrees"}).value_or(0) * M_PI / 180;
  place.clock_sd_ms = board.number("clock_sd_ms", {1e-6, 1e6, "ms"});
  if (!options.boards.emplace(*node, place).second) board.complain("node", "each node once", "\"" + *node + "\" twice");
}

}  // namespace

Outcome<void> read_fusion_file(const std::filesystem::path& file, FusionOptions& options) {
  auto toml = TomlFile::load(file);
  if (!toml) return toml.error();
  TomlTable root = toml->root();
  TomlTable fusion = root.table("fusion");
  if (const auto id = fusion.text("id")) {
    if (proto::NodeId::make(*id))
      options.id = *id;
    else
      fusion.complain("id", "a node's name: 1 to 31 letters, digits, '-', '_', '.'", "\"" + *id + "\"");
  }
  options.pair_ms = fusion.number("pair_ms", {0.001, 1000, "ms"});
  if (root.has("surface")) read_surface(root.table("surface"), options);
  for (TomlTable& board : root.tables("board")) {
    read_board(board, options);
    if (options.boards.contains(options.id))
      board.complain("node", "another name than the fused node's", "\"" + options.id + "\"");
  }
  if (options.boards.size() == 1) root.complain("", "at least two boards of one surface", "one [[board]]");
  if (options.boards.size() > Fusion::kMaxBoards)
    root.complain("", "at most 32 boards", std::to_string(options.boards.size()) + " [[board]]s");
  bool turned = !options.boards.empty();
  for (const auto& [name, board] : options.boards) turned = turned && board.placement.turn_rad != 0;
  if (turned && !options.model) root.missing("surface", "the common surface, since every board is turned against it");
  return toml->finish();
}

}  // namespace srd::host
