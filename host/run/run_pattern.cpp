// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <ctime>

#include "drivers/recording/image_file.hpp"
#include "dsp/estimate/estimator/start_history.hpp"
#include "host/run/ordered_work.hpp"
#include "host/run/pattern_mask.hpp"
#include "host/run/pose_estimation.hpp"
#include "host/run/run_kinds.hpp"
#include "proto/frame_from_estimate.hpp"

namespace srd::host {

namespace {

// A block starts from the guess, whatever came before it: blocks can then be fitted side by side.
constexpr std::size_t kBlock = 25;  // frames
// Of the grey levels' variance. A pattern that lies a third of a square off along one axis explains a ninth; a fit that
// does not explain more than twice that has not found it.
constexpr double kMinExplained = 0.25;

struct Block {
  std::vector<FrameRecord> frames;
  std::vector<std::string> warnings;
};

double thread_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

bool found_pattern(const dsp::PatternEstimate& estimate) {
  return !dsp::failed(estimate.surface.stop) && estimate.explained >= kMinExplained;
}

class BlockFitter {
 public:
  BlockFitter(const RunPlan& plan, const dsp::PatternEstimator& estimator) : plan_(plan), estimator_(estimator) {}

  Block fit(std::size_t block) {
    Block out;
    dsp::StartHistory<double> history(plan_.guess);
    const std::size_t total = plan_.cameras.front().frames.size();
    for (std::size_t i = block * kBlock; i < std::min(total, (block + 1) * kBlock); ++i) {
      const double began = thread_seconds();
      FrameRecord record;
      fit_frame(i, history, record, out.warnings);
      record.seconds = thread_seconds() - began;
      out.frames.push_back(std::move(record));
    }
    return out;
  }

 private:
  void fit_frame(std::size_t i, dsp::StartHistory<double>& history, FrameRecord& record, std::vector<std::string>& warnings) {
    record.name = plan_.cameras.front().frames[i].filename().string();
    record.sequence = plan_.sequences[i];
    record.time_ns = plan_.times_ns[i];
    record.corners.resize(plan_.cameras.size());
    const PatternRun& pattern = *plan_.pattern_run;
    std::vector<GrayImage> images;
    std::vector<std::vector<std::uint8_t>> masks;
    for (std::size_t c = 0; c < plan_.cameras.size(); ++c) {
      const RunCamera& camera = plan_.cameras[c];
      Outcome<GrayImage> image = read_gray_image(camera.frames[i], plan_.sample_bits);
      const Outcome<void> right = image ? check_size(image->view(), camera.calibration, camera.frames[i]) : Outcome<void>();
      if (!image || !right) {
        const Problem& problem = image ? right.error() : image.error();
        warnings.push_back(problem.where + ": " + problem.what + "; the frame has no surface");
        record.status = proto::FrameStatus::kBadFrame;
        return;
      }
      masks.push_back(pattern_mask(image->view(), pattern.regions[c], pattern.dark_below, pattern.bright_above));
      record.expected +=
          static_cast<int>(std::count_if(masks[c].begin(), masks[c].end(), [](std::uint8_t used) { return used != 0; }));
      images.push_back(std::move(*image));
    }
    std::vector<GrayView> views;
    std::vector<std::span<const std::uint8_t>> used;
    for (std::size_t c = 0; c < images.size(); ++c) {
      views.push_back(images[c].view());
      used.emplace_back(masks[c]);
    }
    dsp::PatternEstimate found = estimator_.estimate(views, used, history.starts(record.time_ns));
    if (!found_pattern(found) && history.size() > 0) found = estimator_.estimate(views, used, std::span(&plan_.guess, 1));
    record.found = found.pixels;
    record.estimate = found.surface;
    record.status = proto::status_of(found.surface.stop);
    if (!record.has_surface()) return;
    if (!found_pattern(found)) {
      record.estimate = {};
      record.status = proto::FrameStatus::kFailed;
      return;
    }
    history.add(record.time_ns, record.estimate.coefficients);
    dsp::Trace<double> way;
    if (pattern.surface.follow({plan_.cameras.front().pose.centre(), pattern.centre_ray}, record.estimate.coefficients,
                               plan_.media, pattern.plane.z, way, 0))
      record.centre = way.surface_point.head<2>();
  }

  const RunPlan& plan_;
  dsp::PatternEstimator estimator_;
};

}  // namespace

Outcome<RunResult> run_pattern(const RunPlan& plan, const Progress& progress) {
  const PatternRun& pattern = *plan.pattern_run;
  std::vector<dsp::PatternView> views;
  for (std::size_t c = 0; c < plan.cameras.size(); ++c)
    views.push_back({{plan.cameras[c].calibration.camera, plan.cameras[c].pose}, pattern.regions[c]});
  const auto estimator = dsp::PatternEstimator::make(views, pattern.surface, plan.media, pattern.plane, pattern.options);
  if (!estimator) return unusable_model(estimator.error());
  const std::size_t total = plan.cameras.front().frames.size(), blocks = (total + kBlock - 1) / kBlock;
  const int threads = static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(plan.threads), blocks));
  std::vector<BlockFitter> fitters(static_cast<std::size_t>(std::max(threads, 1)), BlockFitter(plan, *estimator));
  OrderedWork<Block> work(threads, blocks, static_cast<std::size_t>(2 * std::max(threads, 1)),
                          [&](std::size_t block, int thread) { return fitters[static_cast<std::size_t>(thread)].fit(block); });
  RunResult result;
  for (std::size_t block = 0; block < blocks; ++block) {
    Block done = work.take();
    std::move(done.frames.begin(), done.frames.end(), std::back_inserter(result.frames));
    std::move(done.warnings.begin(), done.warnings.end(), std::back_inserter(result.warnings));
    if (progress) progress(result.frames.size(), total);
  }
  return result;
}

}  // namespace srd::host
