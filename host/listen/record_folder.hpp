// SPDX-License-Identifier: Apache-2.0
// The record of a host as MCAP: a folder with segments 000001.mcap, 000002.mcap, .. A frame is safe once flush() has returned:
// its chunk is on the disk (fdatasync).
//
// A message is the frame as its node sent it, a srd.wire.NodeDatagram of proto/srd.proto, whose schema is in each file; a
// channel a node, /NODE; log time: when it was recorded, publish time: the node's wall clock, or the log time where it has none.
// Every run begins a segment, and so does every kSegmentBytes; what a killed run or a power cut left at the end of a segment
// stays there, and readers stop before it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "drivers/support/unique_fd.hpp"
#include "host/coefficients/frame_sink.hpp"
#include "host/listen/mcap_format.hpp"
#include "host/listen/sequence_set.hpp"

namespace srd::host {

class RecordFolder final : public FrameSink {
 public:
  static constexpr std::uint64_t kSegmentBytes = std::uint64_t{64} << 20;

  // Makes the folder when it is not there, and reads which frames its segments have. wall_clock: ns since 1970 UTC.
  // kInput: a segment that is none, or cannot be read; kDevice: what cannot be written.
  [[nodiscard]] static Outcome<std::unique_ptr<RecordFolder>> open(const std::filesystem::path& folder,
                                                                   std::function<std::int64_t()> wall_clock,
                                                                   std::uint64_t segment_bytes = kSegmentBytes);
  // Ends the segment with its index.
  ~RecordFolder() override;

  [[nodiscard]] Outcome<void> write(const proto::BootId& from, std::uint64_t sequence,
                                    const proto::CoefficientFrame& frame) override;
  [[nodiscard]] Outcome<void> flush() override;

  // What the segments had when they were opened.
  [[nodiscard]] const std::map<proto::BootId, SequenceSet>& frames_in_file() const { return in_file_; }

  // The frames of a record in the order in which they were recorded, as far as they are whole. kInput as open.
  using Use = std::function<void(const proto::BootId& from, std::uint64_t sequence, const proto::CoefficientFrame& frame)>;
  [[nodiscard]] static Outcome<void> read(const std::filesystem::path& folder, const Use& use);

 private:
  RecordFolder(std::filesystem::path folder, std::function<std::int64_t()> wall_clock, std::uint64_t segment_bytes)
      : folder_(std::move(folder)), wall_clock_(std::move(wall_clock)), segment_bytes_(segment_bytes) {}
  [[nodiscard]] Outcome<void> begin_segment();
  [[nodiscard]] Outcome<void> end_segment();
  [[nodiscard]] Outcome<void> append(const std::string& bytes);

  std::filesystem::path folder_;
  std::function<std::int64_t()> wall_clock_;
  std::uint64_t segment_bytes_;
  std::map<proto::BootId, SequenceSet> in_file_;
  std::uint64_t next_segment_ = 1;
  std::filesystem::path file_;
  UniqueFd fd_;  // of the open segment; none before the first frame
  std::uint64_t bytes_ = 0;
  std::unique_ptr<mcap::Writer> writer_;
  std::map<proto::NodeId, std::uint16_t> channels_;
};

}  // namespace srd::host
