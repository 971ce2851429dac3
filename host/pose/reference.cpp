// SPDX-License-Identifier: Apache-2.0
#include "host/pose/reference.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/recording/natural_order.hpp"
#include "drivers/support/formatted.hpp"

namespace srd::host {

namespace {

namespace fs = std::filesystem;

// A move of all corners by more than this between images that are averaged is no noise, px.
constexpr double kMaxMove = 0.5;
constexpr double kRestlessFactor = 2;

Outcome<std::vector<fs::path>> reference_files(const std::vector<fs::path>& given) {
  std::vector<fs::path> files;
  for (const fs::path& path : given) {
    std::error_code error;
    if (!fs::is_directory(path, error)) {
      files.push_back(path);
      continue;
    }
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(path, error))
      if (is_image_name(entry.path())) names.push_back(entry.path().filename().string());
    if (names.empty())
      return Problem{Exit::kInput,
                     "holds no images",
                     path.string(),
                     "images of the pattern (.png, .pgm, .tif, .bmp, .jpg)",
                     "",
                     "name the images themselves, or their folder"};
    (void)sort_naturally(names);
    for (const std::string& name : names) files.push_back(path / name);
  }
  return files;
}

struct SeenBoard {
  std::vector<BoardCorner> corners;
  PatternSize seen;
};

Outcome<SeenBoard> board_in(const GrayView& image, PatternSize board, bool either_way, const CornerSearch& search,
                            const std::string& where) {
  auto corners = find_board_corners(image, board, search, where);
  if (corners) return SeenBoard{std::move(corners).value(), board};
  if (!either_way || board.rows == board.columns) return corners.error();
  const PatternSize turned{board.columns, board.rows};
  auto other = find_board_corners(image, turned, search, where);
  if (!other) return corners.error();
  return SeenBoard{std::move(other).value(), turned};
}

}  // namespace

Outcome<ReferenceView> read_reference(const std::vector<fs::path>& images, const Calibration& calibration, PatternSize board,
                                      const CornerSearch& search) {
  const auto files = reference_files(images);
  if (!files) return files.error();
  ReferenceView view;
  std::vector<std::vector<BoardCorner>> all;
  for (const fs::path& file : *files) {
    Outcome<GrayImage> image = read_gray_image(file);
    if (!image) return image.error();
    if (auto right = check_size(image->view(), calibration, file); !right) return right.error();
    auto seen = board_in(image->view(), all.empty() ? board : view.seen, all.empty(), search, file.string());
    if (!seen) return seen.error();
    if (all.empty()) {
      view.seen = seen->seen;
      view.image = std::move(image).value();
    }
    all.push_back(std::move(seen->corners));
  }
  view.corners = all.front();
  if (all.size() == 1) return view;

  double chi2 = 0;
  std::vector<dsp::Vec2<double>> moves(all.size(), dsp::Vec2<double>::Zero());
  for (std::size_t i = 0; i < view.corners.size(); ++i) {
    double weights = 0;
    dsp::Vec2<double> sum = dsp::Vec2<double>::Zero();
    for (const auto& corners : all) {
      const double weight = 1 / (corners[i].sigma_px * corners[i].sigma_px);
      weights += weight;
      sum += weight * corners[i].pixel;
    }
    BoardCorner& mean = view.corners[i];
    mean.pixel = sum / weights;
    mean.sigma_px = 1 / std::sqrt(weights);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const dsp::Vec2<double> off = all[k][i].pixel - mean.pixel;
      chi2 += off.squaredNorm() / (all[k][i].sigma_px * all[k][i].sigma_px);
      moves[k] += off / static_cast<double>(view.corners.size());
    }
  }
  const auto freedom = 2.0 * static_cast<double>(view.corners.size() * (all.size() - 1));
  view.scatter_factor = chi2 / freedom;
  const auto most = std::max_element(moves.begin(), moves.end(),
                                     [](const auto& a, const auto& b) { return a.squaredNorm() < b.squaredNorm(); });
  const fs::path& worst = (*files)[static_cast<std::size_t>(most - moves.begin())];
  if (most->norm() > kMaxMove)
    return Problem{Exit::kInput,
                   "shows the pattern in another place than the other images",
                   worst.string(),
                   "images between which neither camera nor pattern has moved, to average them",
                   formatted("its corners lie %.2f px from the mean of all", most->norm()),
                   "leave it out; 'srd rig-check' tells what moved"};
  if (view.scatter_factor > kRestlessFactor)
    view.warnings.push_back(
        formatted("the images scatter %.1f times more than their corners' deviations say: something moves a little; ",
                  std::sqrt(view.scatter_factor)) +
        formatted("the mean of %s is farthest, %.4f px from all", worst.filename().c_str(), most->norm()));
  return view;
}

}  // namespace srd::host
