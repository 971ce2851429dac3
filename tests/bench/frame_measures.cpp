// SPDX-License-Identifier: Apache-2.0
// One tracked frame, whole and in parts.
#include <memory>
#include <opencv2/imgproc.hpp>

#include "dsp/frontend/corner_tracker.hpp"
#include "dsp/pipeline/prediction.hpp"
#include "tests/bench/frame_chain.hpp"
#include "tests/bench/measures.hpp"
#include "tests/bench/prerendered.hpp"

namespace srd::bench {

namespace {

constexpr int kFrames = 12;

struct Frame {
  FrameSequence sequence = prerendered_frames(kFrames);
  FrameChain chain = FrameChain::make(sequence).value();
  std::int64_t turn = 0;
  // Of one frame, for the parts.
  dsp::View<float> view = setup_of(sequence).view;
  dsp::SurfaceModel<float> model = sequence.model.cast<float>();
  dsp::Media<float> media = media_of(sequence);
  std::vector<dsp::Vec3<float>> points;
  dsp::Coefficients<float> surface;
  std::vector<dsp::Vec2<float>> starts;
  std::vector<dsp::CornerShape> shapes;
  cv::Mat harris;

  // There and back through the frames: every one is near the one before.
  void step() {
    constexpr int kPeriod = 2 * (kFrames - 1);
    const int at = static_cast<int>(turn % kPeriod);
    const int frame = at < kFrames ? at : kPeriod - at;
    if (chain.process(sequence.image(frame), turn * 20'000'000) == 0) refuse("a frame gives no datagram");
    if (!chain.result().has_surface() || (turn > 0 && chain.result().acquired)) refuse("the chain loses its track");
    ++turn;
  }
};

}  // namespace

void add_frame_measures(std::vector<Measure>& measures) {
  const auto frame = std::make_shared<Frame>();
  for (int i = 0; i < 2 * kFrames; ++i) frame->step();
  if (frame->chain.result().estimate.corners_used != 276)
    refuse("the chain uses " + std::to_string(frame->chain.result().estimate.corners_used) + " of 276 corners");
  for (const auto& point : frame->sequence.points()) frame->points.push_back(point.cast<float>());
  FrameChain first = FrameChain::make(frame->sequence).value();
  (void)first.process(frame->sequence.image(0), 0);
  frame->surface = first.result().estimate.coefficients;
  const auto pattern = dsp::Pattern::make(frame->sequence.points(), dsp::FirstSquare::kDark).value();
  for (std::size_t i = 0; i < frame->points.size(); ++i) {
    const auto p = dsp::predict(frame->view, frame->model, frame->surface, frame->media, frame->points[i],
                                frame->view.normalised(frame->points[i]).value());
    frame->starts.push_back(p->normalised);
    frame->shapes.push_back(dsp::expected_shape(*p, pattern.odd(static_cast<int>(i)), 3300));
  }

  measures.push_back({"frame/chain", [=] { frame->step(); }});
  measures.push_back({"frame/cornerHarris", [=] {
                        const auto& pixels = frame->sequence.frames[0];
                        const cv::Mat image(frame->sequence.height, frame->sequence.width, CV_8U,
                                            const_cast<std::uint8_t*>(pixels.data()));
                        cv::cornerHarris(image, frame->harris, 5, 3, 0.04);
                      }});
  measures.push_back(
      {"frame/predict", [=] {
         for (std::size_t i = 0; i < frame->points.size(); ++i)
           if (!dsp::predict(frame->view, frame->model, frame->surface, frame->media, frame->points[i], frame->starts[i]))
             refuse("a corner cannot be predicted");
       }});
  measures.push_back({"frame/track", [=] {  // response in the windows, maxima, and the fit
                        dsp::CornerFit fit;
                        for (const auto& shape : frame->shapes)
                          if (dsp::track_corner(frame->sequence.image(0), {}, shape, 6, {}, fit) != dsp::Tracked::kFound)
                            refuse("a corner is not tracked");
                      }});
  measures.push_back({"frame/fit", [=] {
                        dsp::CornerFit fit;
                        for (const auto& shape : frame->shapes)
                          if (!dsp::fit_corner(frame->sequence.image(0), shape, {}, fit)) refuse("a corner is not fitted");
                      }});
  measures.push_back({"frame/encode", [=] {
                        if (frame->chain.encode() == 0) refuse("a record cannot be encoded");
                      }});
  const auto key = std::make_shared<proto::Key>(std::array<std::uint8_t, proto::Key::kBytes>{1});
  measures.push_back({"frame/tag", [=] {
                        if (frame->chain.seal(*key) == 0) refuse("a datagram cannot be tagged");
                      }});
}

}  // namespace srd::bench
