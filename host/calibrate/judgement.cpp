// SPDX-License-Identifier: Apache-2.0
#include "host/calibrate/judgement.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "drivers/support/formatted.hpp"
#include "host/bundle/lens.hpp"

namespace srd::host {

namespace {

constexpr int kFields = 10;
constexpr std::size_t kMinViews = 4;
constexpr double kDegrees = 57.29577951308232;
constexpr double kMinExtent = 0.12;      // of the image's width: smaller boards tell nothing of the lens
constexpr double kFrontal = 8;           // degrees: a board tilted less does not tell focal length from distance
constexpr double kMaxFocalError = 0.02;  // of the focal length: beyond, no calibration but a guess
constexpr double kMaxZoom = 1e-3;        // of the focal length: less is what warmth and gravity do to a lens
constexpr double kManyLeftOut = 0.3;     // of a view's corners: no stray ones
constexpr double kMaxRms = 3;            // px: corners of one camera and one board leave far less

std::string size_text(int width, int height) { return std::to_string(width) + " x " + std::to_string(height) + " px"; }

double extent_of(const SightedBoard& board) {
  double low_u = 1e9, high_u = -1e9, low_v = 1e9, high_v = -1e9;
  for (const auto& corner : board.view.corners) {
    low_u = std::min(low_u, corner.pixel.x());
    high_u = std::max(high_u, corner.pixel.x());
    low_v = std::min(low_v, corner.pixel.y());
    high_v = std::max(high_v, corner.pixel.y());
  }
  return std::max(high_u - low_u, high_v - low_v) / board.width;
}

std::string zoom_text(const CalibrationResult& result) {
  const bundle::ZoomChange& zoom = *result.zoom;
  std::vector<std::pair<std::size_t, std::string>> names;
  for (const SightedBoard& view : result.sighted) names.emplace_back(view.number, view.view.name);
  std::sort(names.begin(), names.end());
  return "from about " + names[zoom.from].second +
         formatted(
             " on the focal length is %.2f %% +- %.2f %% %s (chi-square %.0f; in 999 of 1000 sets chance stays below %.0f)",
             100 * std::abs(zoom.part), 100 * zoom.deviation, zoom.part > 0 ? "longer" : "shorter", zoom.chi_square,
             zoom.limit);
}

double tilt_of(const bundle::PoseVector& pose) {
  const double cosine = std::abs(bundle::Turn(pose.head<3>()).rotation(2, 2));
  return std::acos(std::min(cosine, 1.0)) * kDegrees;
}

}  // namespace

Coverage coverage_of(const CalibrationResult& result) {
  Coverage coverage;
  coverage.fields.assign(kFields * kFields, 0);
  for (const auto& view : result.views)
    for (const auto& corner : view.corners) {
      const int u = std::clamp(static_cast<int>(kFields * corner.pixel.x() / result.width), 0, kFields - 1);
      const int v = std::clamp(static_cast<int>(kFields * corner.pixel.y() / result.height), 0, kFields - 1);
      coverage.fields[static_cast<std::size_t>(v * kFields + u)] = 1;
    }
  coverage.image_part =
      static_cast<double>(std::count(coverage.fields.begin(), coverage.fields.end(), char{1})) / (kFields * kFields);
  coverage.least_tilt = 90;
  std::vector<double> distances;
  const bundle::BoardShape& board = result.board;
  const Eigen::Vector3d middle((board.rows - 1) * board.square_mm / 2, (board.columns - 1) * board.square_mm / 2, 0);
  for (std::size_t i = 0; i < result.fit.views.size(); ++i) {
    const auto& pose = result.fit.views[i].pose;
    coverage.least_tilt = std::min(coverage.least_tilt, tilt_of(pose));
    coverage.most_tilt = std::max(coverage.most_tilt, tilt_of(pose));
    coverage.largest_extent = std::max(coverage.largest_extent, extent_of(result.sighted[i]));
    distances.push_back((bundle::Turn(pose.head<3>()).rotation * middle + pose.tail<3>()).norm());
  }
  std::sort(distances.begin(), distances.end());
  coverage.near_mm = distances.front();
  coverage.usual_mm = distances[distances.size() / 2];
  coverage.far_mm = distances.back();
  return coverage;
}

Outcome<void> check_views(const bundle::BoardShape& board, const std::vector<SightedBoard>& sighted) {
  std::map<std::pair<int, int>, std::vector<std::string>> sizes;
  for (const SightedBoard& view : sighted) sizes[{view.width, view.height}].push_back(view.view.name);
  if (sizes.size() > 1) {
    std::string found;
    for (const auto& [size, names] : sizes)
      found += (found.empty() ? "" : "; ") + size_text(size.first, size.second) + ": " + std::to_string(names.size()) +
               " images, first " + names.front();
    return Problem{
        Exit::kInput, "images of different sizes",
        "the images", "images of one camera at one size",
        found,        "calibrate each size for itself: scaled or cropped images have another centre and focal length"};
  }
  const auto whole = static_cast<std::size_t>(
      std::count_if(sighted.begin(), sighted.end(), [&](const SightedBoard& view) { return view.whole_extent(board); }));
  if (whole == 0) {
    int rows = 0, columns = 0;
    for (const SightedBoard& view : sighted) {
      rows = std::max(rows, view.rows);
      columns = std::max(columns, view.columns);
    }
    return Problem{Exit::kInput,
                   "no image shows the whole board",
                   "the images",
                   std::to_string(board.columns) + " x " + std::to_string(board.rows) + " inner corners in at least " +
                       std::to_string(kMinViews) + " images",
                   "at most " + std::to_string(columns) + " x " + std::to_string(rows),
                   "count the inner corners again; if the size is right, take images with the whole board in view"};
  }
  if (whole < kMinViews)
    return Problem{Exit::kInput,
                   "too few views of the whole board",
                   "the images",
                   "at least " + std::to_string(kMinViews) + ", better 12 to 20",
                   std::to_string(whole) +
                       (sighted.size() > whole ? " whole and " + std::to_string(sighted.size() - whole) + " in part" : ""),
                   "take more: the board in every part of the image, tilted by 20 to 45 degrees, each time another way"};
  double largest = 0;
  for (const SightedBoard& view : sighted) largest = std::max(largest, extent_of(view));
  if (largest < kMinExtent)
    return Problem{
        Exit::kInput,
        "the board is too small in every image",
        "the images",
        "a board that takes up at least " + formatted("%.0f %%", 100 * kMinExtent) + " of the image's width, better half of it",
        formatted("%.1f %%", 100 * largest),
        "hold the board nearer to the camera, or use a larger one"};
  return {};
}

Outcome<void> check_fit(const CalibrationResult& result) {
  const bundle::CameraFit& fit = result.fit;
  if (result.zoom && result.zoom->found() && std::abs(result.zoom->part) > kMaxZoom)
    return Problem{
        Exit::kInput,
        "zoom or focus was changed among the images",
        "the images",
        "one focal length in all of them",
        zoom_text(result),
        "take all images with zoom and focus fixed (automatic focus off, the rings taped), or calibrate those before "
        "the change and those behind it each for themselves"};
  if (result.coverage.most_tilt < kFrontal)
    return Problem{
        Exit::kInput,
        "the board faces the camera in every image",
        "the images",
        "boards tilted by 20 to 45 degrees in most of them",
        formatted("at most %.1f degrees", result.coverage.most_tilt),
        "tilt the board, each time another way: square on, nothing tells a long lens far away from a short one near by"};
  const double all_used = static_cast<double>(fit.used) / (fit.used + fit.rejected);
  if (fit.rms_px > kMaxRms || all_used < 0.7) {
    std::string worst;
    double most = 0;
    for (std::size_t i = 0; i < fit.views.size(); ++i) {
      double sum = 0;
      for (const auto& r : fit.views[i].residuals) sum += r.squaredNorm();
      if (sum / static_cast<double>(fit.views[i].residuals.size()) <= most) continue;
      most = sum / static_cast<double>(fit.views[i].residuals.size());
      worst = result.views[i].name;
    }
    return Problem{Exit::kInput,
                   "the images contradict each other",
                   "the images",
                   "one board seen by one camera whose zoom and focus stay as they are",
                   formatted("%.2f px rms, %d of %d corners left out; ", fit.rms_px, fit.rejected, fit.used + fit.rejected) +
                       worst + " worst",
                   "take all images with zoom, focus and autofocus fixed, of one stiff board; leave out images of other days"};
  }
  for (const int i : {0, 1}) {
    const double part = fit.deviation(i) / fit.intrinsics[static_cast<std::size_t>(i)];
    if (part <= kMaxFocalError) continue;
    return Problem{Exit::kInput,
                   "the views do not determine the focal length",
                   "the images",
                   formatted("a standard error of at most %.0f %%", 100 * kMaxFocalError),
                   bundle::intrinsic_name(i) + formatted(" %.0f +- %.0f px (%.1f %%), boards tilted by %.0f to %.0f degrees",
                                                         fit.intrinsics[static_cast<std::size_t>(i)], fit.deviation(i),
                                                         100 * part, result.coverage.least_tilt, result.coverage.most_tilt),
                   "add views: next " + result.next.place + ", " + result.next.attitude};
  }
  return {};
}

std::vector<std::string> remarks(const CalibrationResult& result) {
  std::vector<std::string> list;
  const bundle::CameraFit& fit = result.fit;
  const bundle::ModelCheck& check = result.check;
  if (check.bend_missing())
    list.push_back(
        formatted("The model does not fit: the board is bent by %+.3f mm along its rows' numbers and %+.3f mm along its "
                  "columns' (chi-square %.0f, chance stays below %.0f). ",
                  check.bend.x(), check.bend.y(), check.bend_significance, check.bend_limit) +
        "Estimate the bend too (--surface bent).");
  if (result.zoom && result.zoom->found())
    list.push_back("The focal length is not the same in all images: " + zoom_text(result) + ".");
  if (!check.halves_agree())
    list.push_back(
        formatted("The model does not fit: two halves of the views contradict each other (chi-square %.0f, chance stays "
                  "below %.0f). ",
                  check.halves, check.halves_limit) +
        "More coefficients, a stiffer board, or fixed zoom and focus.");
  if (fit.views_contradict)
    list.push_back(
        formatted("Views contradict each other by %.1f times what independent corners explain; every stated error is that "
                  "much wider. Usual causes: a board that flexes in the hand, motion, changing focus.",
                  std::sqrt(fit.view_factor)));
  if (fit.stated_ratio > 2)
    list.push_back(
        formatted("Corners are %.1f times further off than their noise explains: %.3f px were added to each corner's own "
                  "deviation.",
                  fit.stated_ratio, fit.added_px));
  const double mean_share = 1.0 / static_cast<double>(fit.views.size());
  for (std::size_t i = 0; i < fit.views.size(); ++i) {
    const bundle::ViewFit& view = fit.views[i];
    const double growth = fit.views_contradict ? std::sqrt(fit.view_factor) : 1;
    const auto left_out = std::count(view.used.begin(), view.used.end(), char{0});
    if (static_cast<double>(left_out) > kManyLeftOut * static_cast<double>(view.used.size())) {
      list.push_back(result.views[i].name + " contradicts the other images: " + std::to_string(left_out) + " of its " +
                     std::to_string(view.used.size()) +
                     " corners are left out. Another zoom or focus, another board, or one that moved?");
      continue;
    }
    if (view.contradiction > 3 * std::max(fit.view_factor, 1.0) && view.moved > 2 * growth)
      list.push_back(result.views[i].name +
                     formatted(" harms: without it a parameter moves by %.1f of its errors. Look at it, or "
                               "leave it out.",
                               view.moved / growth));
    else if (view.share < 0.15 * mean_share)
      list.push_back(result.views[i].name + " adds almost nothing to what the other views say.");
  }
  if (result.coverage.image_part < 0.6)
    list.push_back(
        formatted("Corners lie in %.0f %% of the image; outside, the lens is extrapolated.", 100 * result.coverage.image_part));
  if (result.coverage.most_tilt < 20)
    list.push_back(formatted("No board is tilted by more than %.0f degrees; 20 to 45 tell most.", result.coverage.most_tilt));
  if (fit.views.size() < 10) list.push_back(formatted("Only %zu views; 12 to 20 are usual.", fit.views.size()));
  return list;
}

}  // namespace srd::host
