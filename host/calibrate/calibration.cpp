// SPDX-License-Identifier: Apache-2.0
#include "host/calibrate/calibration.hpp"

#include <algorithm>
#include <numeric>
#include <optional>
#include <span>

#include "drivers/support/formatted.hpp"
#include "host/bundle/resection.hpp"
#include "host/calibrate/judgement.hpp"

namespace srd::host {

namespace {

constexpr std::size_t kMinFreeViews = 12;
constexpr int kMapColumns = 33, kMapRows = 19;

// Indices of the views in the order of their images: parts of a board stand behind the whole ones.
std::vector<std::size_t> taken_order(const std::vector<SightedBoard>& sighted) {
  std::vector<std::size_t> order(sighted.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return sighted[a].number < sighted[b].number; });
  return order;
}

// What the colours say of where a part belongs: by an odd number of rows and columns together, or by an even one. A board with
// one even and one odd side looks the other way round after half a turn, so there they say nothing; nor where views contradict.
std::optional<bool> odd_move(const bundle::BoardShape& board, std::span<const SightedBoard> whole, const SightedBoard& part) {
  if ((board.rows + board.columns) % 2 != 0 || !part.bright_first) return std::nullopt;
  std::optional<bool> bright;
  for (const SightedBoard& view : whole) {
    if (!view.bright_first) continue;
    if (bright && *bright != *view.bright_first) return std::nullopt;
    bright = view.bright_first;
  }
  return bright ? std::optional(*bright != *part.bright_first) : std::nullopt;
}

}  // namespace

Outcome<CalibrationResult> calibrate(const CalibratePlan& plan, CalibrationProgress progress) {
  std::vector<SightedBoard> sighted;
  std::vector<std::string> warnings;
  std::optional<Problem> first;
  for (std::size_t i = 0; i < plan.images.size(); ++i) {
    const auto image = read_gray_image(plan.images[i]);
    if (!image) return image.error();
    auto board = sight_board(*image, plan.images[i], plan.board, plan.search);
    if (progress != nullptr) progress(i + 1, plan.images.size());
    if (board) {
      sighted.push_back(std::move(*board));
      continue;
    }
    if (!first) first = board.error();
    warnings.push_back(plan.images[i].filename().string() + " is left out: " + board.error().what + " (" + board.error().found +
                       ").");
  }
  if (sighted.empty()) {
    if (plan.images.size() > 1) first->what += ", nor does any other of " + std::to_string(plan.images.size()) + " images";
    return *first;
  }
  return calibrate_boards(plan, std::move(sighted), std::move(warnings));
}

Outcome<CalibrationResult> calibrate_boards(const CalibratePlan& plan, std::vector<SightedBoard> sighted,
                                            std::vector<std::string> warnings) {
  if (auto good = check_views(plan.board, sighted); !good) return good.error();
  CalibrationResult result;
  result.board = plan.board;
  result.width = sighted.front().width;
  result.height = sighted.front().height;
  for (std::size_t i = 0; i < sighted.size(); ++i) sighted[i].number = i;
  std::vector<SightedBoard> parts;
  for (SightedBoard& board : sighted) {
    if (!board.whole_extent(plan.board)) {
      parts.push_back(std::move(board));
      continue;
    }
    result.views.push_back(board.view);
    result.sighted.push_back(std::move(board));
  }
  const auto solve = [&](const bundle::CameraOptions& options) {
    return bundle::solve_camera(plan.board, result.views, result.width, result.height, options);
  };
  if (!parts.empty()) {
    // Which corners of the board a part shows, the calibration from the whole ones says.
    const std::size_t whole_ones = result.sighted.size();
    bundle::CameraOptions first = plan.camera;
    if (first.surface == bundle::Surface::kFree) first.surface = bundle::Surface::kBent;
    const auto whole = solve(first);
    if (!whole) return whole.error();
    for (SightedBoard& part : parts) {
      auto view = bundle::place_part(plan.board, part.view, part.rows, part.columns, *whole,
                                     odd_move(plan.board, std::span(result.sighted).first(whole_ones), part));
      if (!view) {
        warnings.push_back(part.view.name + " is left out: its part of the board fits nowhere.");
        continue;
      }
      result.views.push_back(std::move(*view));
      result.sighted.push_back(std::move(part));
    }
  }
  if (plan.camera.surface == bundle::Surface::kFree && result.views.size() < kMinFreeViews)
    return Problem{Exit::kInput,
                   "too few views for a board whose every corner is free",
                   "the images",
                   "at least " + std::to_string(kMinFreeViews),
                   std::to_string(result.views.size()),
                   "take more, or --surface bent"};
  auto fit = solve(plan.camera);
  if (!fit) return fit.error();
  result.fit = std::move(*fit);
  result.zoom = bundle::find_zoom_change(result.board, result.views, result.fit, taken_order(result.sighted));
  result.coverage = coverage_of(result);
  result.next = bundle::next_view(result.board, result.views, result.fit, result.width, result.height);
  if (auto good = check_fit(result); !good) return good.error();
  result.check = bundle::check_model(result.board, result.views, result.width, result.height, plan.camera, result.fit);
  for (const double part : {1.0, 0.5, 2.0})
    result.maps.push_back(bundle::uncertainty_map(result.fit, result.width, result.height, part * result.coverage.usual_mm,
                                                  kMapColumns, kMapRows));
  result.warnings = remarks(result);
  result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
  return result;
}

}  // namespace srd::host
