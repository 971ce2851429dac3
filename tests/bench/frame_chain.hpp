// SPDX-License-Identifier: Apache-2.0
// The board's way of a frame on one thread: camera buffer -> tracked corners -> surface -> datagram ready to send.
#pragma once

#include <array>
#include <optional>

#include "proto/messages.hpp"
#include "proto/node_codec.hpp"
#include "tests/bench/frame_sequence.hpp"

namespace srd::bench {

class FrameChain {
 public:
  // Search +-6 px, reprojection metric, level guess. nullopt: the sequence's numbers do not make a tracker.
  [[nodiscard]] static std::optional<FrameChain> make(const FrameSequence& sequence);

  // Bytes of the datagram; 0 when it could not be encoded. The record says what became of the frame.
  [[nodiscard]] std::size_t process(const GrayView& image, std::int64_t time_ns);
  // Record -> datagram alone.
  [[nodiscard]] std::size_t encode();
  // The end of the last datagram alone, under a key.
  [[nodiscard]] std::size_t seal(const proto::Key& key) { return proto::seal(datagram_, encoded_bytes_, 0, &key); }
  [[nodiscard]] const proto::CoefficientFrame& record() const { return record_; }
  [[nodiscard]] const dsp::FrameResult<float>& result() const { return *result_; }

 private:
  explicit FrameChain(dsp::SurfaceTracker<float> tracker) : tracker_(std::move(tracker)) {}

  dsp::SurfaceTracker<float> tracker_;
  const dsp::FrameResult<float>* result_ = nullptr;
  proto::CoefficientFrame record_;
  proto::BootId from_;
  std::uint64_t sequence_ = 0;
  std::size_t encoded_bytes_ = 0;
  std::array<std::uint8_t, proto::kMaxDatagram> datagram_{};
};

// What the chain's tracker starts from, for measurements of its parts.
[[nodiscard]] dsp::CameraSetup<float> setup_of(const FrameSequence& sequence);
[[nodiscard]] dsp::Media<float> media_of(const FrameSequence& sequence);
[[nodiscard]] dsp::Coefficients<float> guess_of(const FrameSequence& sequence);

}  // namespace srd::bench
