// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/frame_chain.hpp"

#include "proto/frame_from_estimate.hpp"

namespace srd::bench {

dsp::CameraSetup<float> setup_of(const FrameSequence& sequence) {
  return {sequence.view.cast<float>(), sequence.width, sequence.height, {}};
}

dsp::Media<float> media_of(const FrameSequence& sequence) {
  dsp::Media<float> media;
  media.air = static_cast<float>(sequence.media.air);
  media.water = static_cast<float>(sequence.media.water);
  return media;
}

dsp::Coefficients<float> guess_of(const FrameSequence& sequence) {
  dsp::Coefficients<float> guess = dsp::Coefficients<float>::Zero(sequence.model.modes.size());
  guess[0] = static_cast<float>(sequence.level_guess_mm);
  return guess;
}

std::optional<FrameChain> FrameChain::make(const FrameSequence& sequence) {
  const auto points = sequence.points();
  const auto pattern = dsp::Pattern::make(points, dsp::FirstSquare::kDark);
  if (!pattern) return std::nullopt;
  const dsp::CameraSetup<float> setup = setup_of(sequence);
  dsp::SurfaceTrackerOptions options;
  options.search_radius = 6;
  auto tracker = dsp::SurfaceTracker<float>::make(std::span(&setup, 1), *pattern, sequence.model.cast<float>(),
                                                  media_of(sequence), guess_of(sequence), dsp::EstimatorOptions{}, options);
  const auto node = proto::NodeId::make("bench");
  if (!tracker || !node) return std::nullopt;
  FrameChain chain(std::move(tracker).value());
  chain.from_ = {*node, 1};
  chain.record_.model = sequence.model.cast<float>();
  chain.record_.refractive_index = static_cast<float>(sequence.media.water);
  return chain;
}

std::size_t FrameChain::process(const GrayView& image, std::int64_t time_ns) {
  result_ = &tracker_.process(std::span(&image, 1), time_ns);
  record_.stamp.sensor_time_ns = time_ns;
  record_.stamp.clock = ClockId::kMonotonic;
  record_.source_sequence = sequence_;
  proto::set_estimate(result_->estimate, dsp::Metric::kReprojection, record_);
  record_.corners_expected = static_cast<std::uint32_t>(result_->expected);
  record_.corners_found = static_cast<std::uint32_t>(result_->found);
  return encode();
}

std::size_t FrameChain::encode() {
  const auto bytes = proto::encode(from_, sequence_++, record_, datagram_);
  if (!bytes) return 0;
  encoded_bytes_ = *bytes;
  return proto::seal(datagram_, encoded_bytes_, 0);
}

}  // namespace srd::bench
